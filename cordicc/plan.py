"""The plan: what cordicc emits, as frozen data, with its JSON form."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

FORMAT = "cordicc-plan"
VERSION = 1


@dataclass(frozen=True, slots=True)
class Unit:
    """A hardware unit.  `latency` in cycles; `arithmetic` is the data of the target that fixes its bits."""

    id: str
    kind: str
    latency: int


@dataclass(frozen=True, slots=True)
class Operand:
    """What an operand port takes: the name of a value (an input, a result) or a constant.

    A constant is a number of the target's format, written so that it reads back exactly.
    """

    value: str | None = None
    constant: str | None = None


@dataclass(frozen=True, slots=True)
class Operation:
    """One operation in its time slot.

    `op` and `params` are those of the graph (`cordicc.ir.ops`), `mode` says the same in words.
    `start` is the cycle in which the operands enter, `finish` the one from which results are usable.
    `results` names the value of each result port, None where nobody takes it.
    """

    id: str
    op: str
    params: dict[str, Any]
    kind: str
    mode: str
    unit: str
    start: int
    finish: int
    ports: tuple[str, ...]
    operands: tuple[Operand, ...]
    results: tuple[str | None, ...]
    equation: str


@dataclass(frozen=True, slots=True)
class Fifo:
    """One segment of a value's delay between consecutive taps; `depth` in words, `width` in bits.

    `source` is the producing operation, the input, or the FIFO before; `sinks` are the operand ports
    (`o3.y`), outputs (`out.theta`) or the FIFO (`f2`) fed by its end.
    """

    id: str
    value: str
    source: str
    sinks: tuple[str, ...]
    depth: int
    width: int


@dataclass(frozen=True, slots=True)
class Plan:
    """A complete hardware plan.  See `schema/plan.schema.json` for the JSON form of each field."""

    name: str
    description: str
    target: dict[str, Any]
    problem: dict[str, Any]
    options: dict[str, Any]
    initiation_interval: int
    latency_cycles: int
    cau_cycles: int
    units: tuple[Unit, ...]
    operations: tuple[Operation, ...]
    fifos: tuple[Fifo, ...]
    outputs: dict[str, Operand]
    optimal: dict[str, bool]
    bounds: dict[str, int]
    accuracy: dict[str, Any] = field(default_factory=dict)
