"""Random data flow, the scheduling problems and plans made of it, and a stand-in arithmetic."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from cordicc.arith.numbers.formats import Signal
from cordicc.plan.model import Operand, Operation, Plan, Unit
from cordicc.plan.origin import PlanOptions
from cordicc.schedule.delays import delays
from cordicc.schedule.solver.scheduling_problem import OUT, Schedule, SchedulingProblem, Sink, Task, TaskValue
from tests.support.origins import problem_of, target_of

PORTS = ("x", "y", "z")
RESULTS = ("norm", "angle")


@dataclass(frozen=True)
class Flow:
    """Inputs; per operation its latency, operands and result count; outputs.

    A source is the name of a value, or a constant if it starts with a digit.
    """

    inputs: tuple[str, ...]
    operations: tuple[tuple[int, tuple[str, ...], int], ...]
    outputs: tuple[str, ...]

    def results(self, index: int) -> tuple[str, ...]:
        return tuple(f"o{index}.{name}" for name in RESULTS[: self.operations[index][2]])

    def consumers(self) -> dict[str, list[Sink]]:
        found: dict[str, list[Sink]] = {name: [] for name in self.inputs}
        for index in range(len(self.operations)):
            found.update({name: [] for name in self.results(index)})
        for index, (_, sources, _) in enumerate(self.operations):
            for port, source in zip(PORTS, sources, strict=False):
                if source in found:
                    found[source].append((f"o{index}", port))
        for position, source in enumerate(self.outputs):
            if source in found:
                found[source].append((OUT, f"q{position}"))
        return found

    def problem(self) -> SchedulingProblem:
        tasks = tuple(Task(f"o{i}", "mix", latency) for i, (latency, _, _) in enumerate(self.operations))
        producer = {name: f"o{i}" for i in range(len(self.operations)) for name in self.results(i)}
        values = tuple(
            TaskValue(name, producer.get(name), tuple(sinks)) for name, sinks in self.consumers().items()
        )
        return SchedulingProblem(tasks, values)

    def plan(self, schedule: Schedule) -> Plan:
        problem = self.problem()
        consumers = self.consumers()
        fifos = delays(problem, schedule, {value.name: 24 for value in problem.values})
        operations = []
        for index, (latency, sources, _) in enumerate(self.operations):
            start = schedule.start[f"o{index}"]
            operations.append(
                Operation(
                    id=f"o{index}",
                    op="rotate",
                    params={"salt": index, "results": self.operations[index][2]},
                    kind="mix",
                    mode="mix",
                    unit=f"u{index}",
                    start=start,
                    finish=start + latency,
                    ports=PORTS[: len(sources)],
                    operands=tuple(self.operand(source) for source in sources),
                    results=tuple(name if consumers[name] else None for name in self.results(index)),
                    equation="",
                )
            )
        outputs = {f"q{i}": self.operand(source) for i, source in enumerate(self.outputs)}
        return Plan(
            problem=problem_of("random", dict.fromkeys(self.inputs, (-0.25, 0.75)), outputs),
            target=target_of(),
            options=PlanOptions(),
            initiation_interval=1,
            latency_cycles=schedule.latency,
            cau_cycles=0,
            units=tuple(Unit(f"u{i}", "mix", row[0]) for i, row in enumerate(self.operations)),
            operations=tuple(operations),
            fifos=fifos,
            outputs=outputs,
            optimal=dict(schedule.optimal),
            bounds=dict(schedule.bounds),
        )

    def operand(self, source: str) -> Operand:
        return Operand(constant=source) if source[0].isdigit() else Operand(value=source)


@st.composite
def flows(draw: st.DrawFn, most_operations: int = 6, most_latency: int = 5) -> Flow:
    """Return data flow in which every operation leads to an output; some of it is trivial."""
    inputs = tuple(f"i{k}" for k in range(draw(st.integers(1, 3))))
    values = list(inputs)
    rows: list[tuple[int, tuple[str, ...], int]] = []
    for index in range(draw(st.integers(0, most_operations))):
        source = st.sampled_from([*values, "3/7", "2"])
        sources = tuple(draw(st.lists(source, min_size=1, max_size=3)))
        row = draw(st.integers(0, most_latency)), sources, draw(st.integers(1, 2))
        rows.append(row)
        values.extend(f"o{index}.{name}" for name in RESULTS[: row[2]])
    taken = {source for _, sources, _ in rows for source in sources}
    outputs = [f"o{i}.norm" for i, row in enumerate(rows) if not {f"o{i}.{r}" for r in RESULTS} & taken]
    outputs += draw(st.lists(st.sampled_from([*values, "5"]), min_size=not outputs, max_size=2))
    return Flow(inputs, tuple(rows), tuple(outputs))


def with_interval(plan: Plan, interval: int, share: bool) -> Plan:
    """Return the plan with new samples every `interval` cycles, units shared where slots allow."""
    fifos = [replace(fifo, depth=-(-fifo.depth // interval)) for fifo in plan.fifos]
    taken: dict[tuple[str, int], Operation] = {}
    operations = []
    for operation in plan.operations:
        own = operation.finish - operation.start
        candidates = [unit.id for unit in plan.units if unit.latency == own] if share else [operation.unit]
        slot = operation.start % interval
        unit = next(id for id in candidates if (id, slot) not in taken)
        taken[unit, slot] = operation
        operations.append(replace(operation, unit=unit))
    return replace(plan, initiation_interval=interval, operations=tuple(operations), fifos=tuple(fifos))


class FakeFormat:
    """64-bit words; the bits of a double, or a hash read as a number in [0, 1); every 61st is invalid."""

    def encode(self, values: np.ndarray) -> np.ndarray:
        return values.astype(np.float64).view(np.uint64).copy()

    def decode(self, words: np.ndarray) -> np.ndarray:
        return np.where(words % np.uint64(61) == 0, np.nan, (words >> np.uint64(12)) / 2.0**52)


class FakeSystem:
    """The same format for every value and constant."""

    def format(self, spec: Any) -> FakeFormat:
        assert spec is None
        return FORMAT

    def constant(self, text: str) -> Signal:
        return Signal(np.uint64(int.from_bytes(hashlib.sha256(text.encode()).digest()[:8])), FORMAT)


class FakeArithmetic:
    """Results that depend on every bit of every operand and on their order."""

    system = FakeSystem()

    def execute(
        self,
        op: str,
        params: Mapping[str, Any],
        kind: str,
        operands: Sequence[Signal],
        formats: Sequence[Any],
        angle: int | None,
    ) -> tuple[Signal, ...]:
        assert (op, kind, angle) == ("rotate", "mix", None)
        assert len({operand.words.shape for operand in operands}) == 1
        word = np.full(operands[0].words.shape, params["salt"], np.uint64)
        for operand in operands:
            word = (word ^ operand.words) * np.uint64(0x9E3779B97F4A7C15)
            word ^= word >> np.uint64(29)
        return tuple(Signal(word * np.uint64(2 * k + 1), FORMAT) for k in range(params["results"]))


FORMAT = FakeFormat()


def samples(flow_inputs: Sequence[str], count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Return samples, some of them out of range."""
    rng = np.random.default_rng(seed)
    return {name: rng.uniform(-0.34, 0.76, count) for name in flow_inputs}
