"""Circuits of which not every cycle has an operation: what waits stays in one register.

In a pipeline a number that is taken some cycles later goes through a register a cycle.  If operations come
every so many cycles, one register does that is loaded when there is a number and stays as it is.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from cordicc.arith.circuits.circuit import Circuit, Gate, Port


def held(circuit: Circuit, interval: int) -> Circuit:
    """Return the circuit for an operation every `interval` cycles, at least.

    Its results are there in the cycle that is its latency, and in no other.
    """
    if interval == 1:
        return circuit
    cells = circuit.cells
    leaving = {port.cell for port in circuit.outputs}
    waiting = Counter(cell.operands[0] for cell in cells if cell.kind == "register")
    made: list[Gate] = []
    place: list[int] = []
    for number, cell in enumerate(cells):
        operands = tuple(place[each] for each in cell.operands)
        if cell.kind == "register":
            before = made[operands[0]]
            # A number is there from the cycle of its hold on, until another one is.
            if (
                number not in leaving
                and before.kind == "hold"
                and (cell.cycle or 0) < (before.cycle or 0) + interval
            ):
                place.append(operands[0])
                continue
            if waiting[number] and number not in leaving:
                cell = replace(cell, kind="hold")
        place.append(len(made))
        made.append(replace(cell, operands=operands))
    return replace(
        circuit,
        cells=tuple(made),
        inputs=tuple(Port(port.name, place[port.cell]) for port in circuit.inputs),
        outputs=tuple(Port(port.name, place[port.cell]) for port in circuit.outputs),
        notes={place[number]: text for number, text in circuit.notes.items()},
    )
