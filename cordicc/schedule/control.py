"""What a shared unit needs besides itself: multiplexers at its ports, and a control word for each slot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cordicc.plan.model import ControlWord, Fifo, Operand, Operation, Unit


def controlled(
    units: Sequence[Unit], operations: Sequence[Operation], fifos: Sequence[Fifo], interval: int
) -> tuple[Unit, ...]:
    """Return the units, those with several operations with their multiplexers and control words."""
    on: dict[str, list[Operation]] = {}
    for operation in operations:
        on.setdefault(operation.unit, []).append(operation)
    feeder = {sink: fifo.id for fifo in fifos for sink in fifo.sinks}
    unit_of = {name: operation.unit for operation in operations for name in operation.results if name}
    return tuple(
        _shared(unit, on[unit.id], feeder, unit_of, interval) if len(on[unit.id]) > 1 else unit
        for unit in units
    )


def _shared(
    unit: Unit,
    operations: Sequence[Operation],
    feeder: dict[str, str],
    unit_of: dict[str, str],
    interval: int,
) -> Unit:
    in_order = sorted(operations, key=lambda operation: operation.start % interval)
    ports: list[dict[str, int]] = [{} for _ in range(max(len(o.ports) for o in operations))]
    words = []
    for operation in in_order:
        select = []
        for inputs, port, operand in zip(ports, operation.ports, operation.operands, strict=False):
            source = _source(operand, feeder.get(f"{operation.id}.{port}"), unit_of)
            select.append(inputs.setdefault(source, len(inputs)))
        words.append(ControlWord(operation.start % interval, operation.id, tuple(select)))
    return replace(unit, inputs=tuple(tuple(inputs) for inputs in ports), control=tuple(words))


def _source(operand: Operand, fifo: str | None, unit_of: dict[str, str]) -> str:
    """Return what drives a port, as `Unit.inputs` names it."""
    if operand.value is None:
        return f"constant {operand.constant}"
    if fifo is not None:
        return f"fifo {fifo}"
    if operand.value in unit_of:
        return f"unit {unit_of[operand.value]}.{operand.value.rpartition('.')[2]}"
    return f"input {operand.value}"
