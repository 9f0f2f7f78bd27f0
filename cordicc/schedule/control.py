"""What a shared unit needs besides itself: multiplexers at its ports, and a control word for each slot."""

from __future__ import annotations

from dataclasses import replace

from cordicc.plan.model import ControlWord, Unit
from cordicc.plan.netlist import Cell, Netlist


def controlled(netlist: Netlist) -> tuple[Unit, ...]:
    """Return the units, those with several operations with their multiplexers and control words."""
    return tuple(
        _shared(cell, netlist.interval) if len(cell.operations) > 1 else cell.unit
        for cell in netlist.cells.values()
    )


def _shared(cell: Cell, interval: int) -> Unit:
    words = []
    for operation in cell.operations:
        slot = operation.start % interval
        select = tuple(port.select[slot] for port in cell.ports[: len(operation.ports)])
        words.append(ControlWord(slot, operation.id, select))
    inputs = tuple(tuple(str(source) for source in port.sources) for port in cell.ports)
    return replace(cell.unit, inputs=inputs, control=tuple(words))
