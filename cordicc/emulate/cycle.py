"""Cycle-accurate emulation: the plan as a synchronous machine, clock by clock.

Units are pipelines, FIFOs shift registers, and wires run as the plan's FIFO records say.  The
machine knows nothing of schedules: data that does not meet in time is an error or a wrong result.

The sample stream is cut into lanes, contiguous runs of samples.  The lanes are identical copies of
the machine in lockstep, so that a register is one array with a word per lane, or None for a bubble.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cordicc.arith.numbers.formats import Signal
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.base.arrays import Floats
from cordicc.emulate.ports import Outputs, PortFormats, constant_signal, deliver, prepare
from cordicc.plan.model import Fifo, Operand, Operation, Plan, dependence_order

_LANE_SAMPLES = 32
_MOST_LANES = 8192

Register = Signal | None


class MachineError(Exception):
    """Operands that do not meet, or an output that is not there when it should leave."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What the wires carry in a cycle: values and FIFO ends by name, outputs by name when they leave."""

    cycle: int
    values: Mapping[str, Register]
    fifos: Mapping[str, Register]
    outputs: Mapping[str, Floats]


def run(plan: Plan, arithmetic: Arithmetic, inputs: Mapping[str, ArrayLike]) -> Outputs:
    """Return the same as `functional.run`, by running the machine.

    Raises MachineError if the plan's delays do not fit, ValueError for unfit inputs.
    """
    samples, in_range = prepare(plan, inputs)
    count = in_range.size
    if count == 0:
        return deliver({name: np.empty(0) for name in plan.outputs}, in_range)
    steps = min(count, max(_LANE_SAMPLES, -(-count // _MOST_LANES)))
    lanes = -(-count // steps)
    padded = {name: np.pad(array, (0, lanes * steps - count), mode="edge") for name, array in samples.items()}
    stream = {name: array.reshape(lanes, steps).T.copy() for name, array in padded.items()}
    outputs = {name: np.empty((lanes, steps)) for name in plan.outputs}
    step = 0
    for snapshot in clock(plan, arithmetic, stream, steps, lanes):
        if snapshot.outputs:
            for name, numbers in snapshot.outputs.items():
                outputs[name][:, step] = numbers
            step += 1
    return deliver({name: array.reshape(-1)[:count] for name, array in outputs.items()}, in_range)


def clock(
    plan: Plan, arithmetic: Arithmetic, stream: Mapping[str, Floats], steps: int, lanes: int
) -> Iterator[Snapshot]:
    """Yield every cycle until the last outputs left; `stream` holds (steps, lanes) numbers per input.

    Step k enters in cycle k * initiation interval, its outputs leave `latency_cycles` later.
    """
    machine = _Machine(plan, arithmetic, steps, lanes)
    interval = plan.initiation_interval
    for cycle in range(plan.latency_cycles + (steps - 1) * interval + 1):
        step, phase = divmod(cycle, interval)
        fresh = phase == 0 and step < steps
        arriving: dict[str, Register] = dict.fromkeys(stream)
        if fresh:
            arriving.update(machine.formats.encode({name: array[step] for name, array in stream.items()}))
        yield machine.tick(cycle, arriving)


class _Machine:
    """The registers of the machine and one clock tick."""

    def __init__(self, plan: Plan, arithmetic: Arithmetic, steps: int, lanes: int) -> None:
        self._plan = plan
        self._arithmetic = arithmetic
        self.formats = PortFormats.of(plan, arithmetic)
        self._steps = steps
        self._order = dependence_order(plan)
        self._latency = {unit.id: unit.latency for unit in plan.units}
        self._pipelines: dict[str, deque[dict[str, Signal] | None]] = {
            unit.id: deque([None] * unit.latency) for unit in plan.units if unit.latency > 0
        }
        self._registers: dict[str, deque[Register]] = {
            fifo.id: deque([None] * fifo.depth) for fifo in plan.fifos
        }
        # An operand port, an output or a FIFO is fed by the FIFO that names it, else by the value.
        self._feeder = {sink: fifo.id for fifo in plan.fifos for sink in fifo.sinks}
        self._value = {fifo.id: fifo.value for fifo in plan.fifos}
        self._slot = _slots(plan)
        operands = [o for operation in plan.operations for o in operation.operands]
        self._constants = {
            operand.constant: constant_signal(arithmetic, operand, lanes)
            for operand in (*operands, *plan.outputs.values())
            if operand.constant is not None
        }
        self._wires: dict[str, Register] = {}

    def tick(self, cycle: int, arriving: Mapping[str, Register]) -> Snapshot:
        """Run one cycle: wires settle, then every register takes its input."""
        wires = self._wires = dict(arriving)
        for pipeline in self._pipelines.values():
            done = pipeline.popleft()
            if done is not None:
                wires.update(done)
        issued: dict[str, dict[str, Signal]] = {}
        for operation in self._order:
            if (cycle - operation.start) % self._plan.initiation_interval == 0:
                results = self._issue(operation, cycle)
                if results is None:
                    continue
                if self._latency[operation.unit] == 0:
                    wires.update(results)
                else:
                    issued[operation.unit] = results
        snapshot = Snapshot(cycle, wires, {id: self._end(id) for id in self._registers}, self._leaving(cycle))
        for unit, pipeline in self._pipelines.items():
            pipeline.append(issued.get(unit))
        self._shift(cycle)
        return snapshot

    def _issue(self, operation: Operation, cycle: int) -> dict[str, Signal] | None:
        """Return what the operation makes of the operands on its ports, None of a bubble."""
        signals: list[Signal] = []
        absent: list[str] = []
        values = 0
        for port, operand in zip(operation.ports, operation.operands, strict=True):
            signal = self._read(f"{operation.id}.{port}", operand)
            values += operand.value is not None
            if signal is None:
                absent.append(port)
            else:
                signals.append(signal)
        if values == 0 and not self._in_stream(cycle - operation.start):
            return None
        if absent:
            if len(absent) == values:
                return None
            raise MachineError(
                f"cycle {cycle}: operands of {operation.id} do not meet, none on {', '.join(absent)}"
            )
        formats = self.formats.of_results(operation)
        results = self._arithmetic.execute(
            operation.op, operation.params, operation.kind, signals, formats, operation.angle
        )
        return {
            name: signal
            for name, signal in zip(operation.results, results, strict=True)
            if name is not None and signal is not None
        }

    def _leaving(self, cycle: int) -> dict[str, Floats]:
        """Return the outputs that leave in this cycle."""
        if not self._in_stream(cycle - self._plan.latency_cycles):
            return {}
        found: dict[str, Floats] = {}
        for name, operand in self._plan.outputs.items():
            signal = self._read(f"out.{name}", operand)
            if signal is None:
                raise MachineError(f"cycle {cycle}: output {name} is not there")
            found[name] = self.formats.leaving(name, signal)
        return found

    def _in_stream(self, cycles: int) -> bool:
        """Tell whether a step entered the machine so many cycles after the first."""
        step, phase = divmod(cycles, self._plan.initiation_interval)
        return phase == 0 and 0 <= step < self._steps

    def _read(self, sink: str, operand: Operand) -> Register:
        if operand.value is None:
            assert operand.constant is not None
            return self._constants[operand.constant]
        return self._feed(sink, operand.value)

    def _feed(self, sink: str, value: str) -> Register:
        """Return what the wire into a port, an output or a FIFO carries."""
        fifo = self._feeder.get(sink)
        return self._wires.get(value) if fifo is None else self._end(fifo)

    def _end(self, fifo: str) -> Register:
        registers = self._registers[fifo]
        return registers[0] if registers else self._feed(fifo, self._value[fifo])

    def _shift(self, cycle: int) -> None:
        """Shift the FIFOs in whose slot it is, all at once."""
        interval = self._plan.initiation_interval
        moving = {
            id: self._feed(id, self._value[id])
            for id in self._registers
            if (cycle - self._slot[id]) % interval == 0
        }
        for id, word in moving.items():
            self._registers[id].append(word)
            self._registers[id].popleft()


def _slots(plan: Plan) -> dict[str, int]:
    """Return the slot, a cycle modulo the initiation interval, in which each FIFO is fed and shifts.

    A result arrives when it finishes, an input in slot 0, and the word at the end of a FIFO moves on
    when that FIFO's ports read it.
    """
    finish = {name: o.finish for o in plan.operations for name in o.results if name is not None}
    reading = {f"{o.id}.{port}": o.start for o in plan.operations for port in o.ports}
    reading.update((f"out.{name}", plan.latency_cycles) for name in plan.outputs)
    feeder: dict[str, Fifo] = {sink: fifo for fifo in plan.fifos for sink in fifo.sinks}

    def slot(fifo: Fifo) -> int:
        before = feeder.get(fifo.id)
        if before is None:
            return finish.get(fifo.value, 0) % plan.initiation_interval
        taps = (reading[sink] for sink in before.sinks if sink in reading)
        return next(taps, 0) % plan.initiation_interval

    return {fifo.id: slot(fifo) for fifo in plan.fifos}
