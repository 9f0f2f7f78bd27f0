"""Cycle-accurate emulation: the plan as a synchronous machine, clock by clock.

Units are pipelines, or busy for some cycles, FIFOs shift registers, and wires run as in the plan's
netlist.  The machine knows nothing of schedules: data that does not meet in time is an error or a wrong
result.

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
from cordicc.plan.model import Operation, Plan, dependence_order
from cordicc.plan.netlist import ConstantWord, Driver, FifoEnd, InputWord, Netlist

_LANE_SAMPLES = 32
_MOST_LANES = 8192

Register = Signal | None


class MachineError(Exception):
    """Operands that do not meet, a unit that is busy, or an output that is not there when it should leave."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What each driver has on its wire in a cycle, if anything, and the outputs by name when they leave."""

    cycle: int
    wires: Mapping[Driver, Register]
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
        self._netlist = Netlist.of(plan)
        self._latency = {unit.id: unit.latency for unit in plan.units}
        self._busy = {unit.id: unit.initiation_interval for unit in plan.units}
        self._free_from = dict.fromkeys(self._busy, 0)
        self._pipelines: dict[str, deque[dict[Driver, Signal] | None]] = {
            unit.id: deque([None] * unit.latency) for unit in plan.units if unit.latency > 0
        }
        self._registers: dict[str, deque[Register]] = {
            fifo.id: deque([None] * fifo.depth) for fifo in plan.fifos
        }
        operands = [o for operation in plan.operations for o in operation.operands]
        self._constants: dict[Driver, Register] = {
            ConstantWord(operand.constant): constant_signal(arithmetic, operand, lanes)
            for operand in (*operands, *plan.outputs.values())
            if operand.constant is not None
        }
        self._wires: dict[Driver, Register] = {}

    def tick(self, cycle: int, arriving: Mapping[str, Register]) -> Snapshot:
        """Run one cycle: wires settle, then every register takes its input."""
        wires = self._wires = dict(self._constants)
        wires.update((InputWord(name), register) for name, register in arriving.items())
        for pipeline in self._pipelines.values():
            done = pipeline.popleft()
            if done is not None:
                wires.update(done)
        issued: dict[str, dict[Driver, Signal]] = {}
        for operation in self._order:
            if (cycle - operation.start) % self._plan.initiation_interval == 0:
                results = self._issue(operation, cycle)
                if results is None:
                    continue
                if cycle < self._free_from[operation.unit]:
                    raise MachineError(f"cycle {cycle}: {operation.unit} is busy as {operation.id} enters")
                self._free_from[operation.unit] = cycle + self._busy[operation.unit]
                if self._latency[operation.unit] == 0:
                    wires.update(results)
                else:
                    issued[operation.unit] = results
        ends = [FifoEnd(id) for id in self._registers]
        wires |= {end: self._carried(end) for end in ends}
        snapshot = Snapshot(cycle, wires, self._leaving(cycle))
        for unit, pipeline in self._pipelines.items():
            pipeline.append(issued.get(unit))
        self._shift(cycle)
        return snapshot

    def _issue(self, operation: Operation, cycle: int) -> dict[Driver, Signal] | None:
        """Return what the operation makes of the operands on its ports, None of a bubble."""
        signals: list[Signal] = []
        absent: list[str] = []
        values = 0
        for port, connection in zip(operation.ports, self._netlist.operands[operation.id], strict=True):
            signal = self._carried(connection.driver)
            values += connection.value is not None
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
            operation.op, operation.settings, operation.kind, signals, formats, operation.angle
        )
        return {
            self._netlist.results[name].driver: signal
            for name, signal in zip(operation.results, results, strict=True)
            if name is not None and signal is not None
        }

    def _leaving(self, cycle: int) -> dict[str, Floats]:
        """Return the outputs that leave in this cycle."""
        if not self._in_stream(cycle - self._plan.latency_cycles):
            return {}
        found: dict[str, Floats] = {}
        for name, connection in self._netlist.outputs.items():
            signal = self._carried(connection.driver)
            if signal is None:
                raise MachineError(f"cycle {cycle}: output {name} is not there")
            found[name] = self.formats.leaving(name, signal)
        return found

    def _in_stream(self, cycles: int) -> bool:
        """Tell whether a step entered the machine so many cycles after the first."""
        step, phase = divmod(cycles, self._plan.initiation_interval)
        return phase == 0 and 0 <= step < self._steps

    def _carried(self, driver: Driver) -> Register:
        """Return what the wire of a driver carries: of a FIFO without entries what enters it."""
        if not isinstance(driver, FifoEnd):
            return self._wires.get(driver)
        registers = self._registers[driver.fifo]
        return registers[0] if registers else self._carried(self._netlist.fifos[driver.fifo].driver)

    def _shift(self, cycle: int) -> None:
        """Shift the FIFOs in whose slot it is, all at once."""
        moving = {
            id: self._carried(connection.driver)
            for id, connection in self._netlist.fifos.items()
            if (cycle - connection.cycle) % self._netlist.interval == 0
        }
        for id, word in moving.items():
            self._registers[id].append(word)
            self._registers[id].popleft()
