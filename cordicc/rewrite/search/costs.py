"""What operations cost on a target: CAUs, multipliers, cycles and area, and how goals order them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.roundings import Words
from cordicc.targets.sized import most_guard_bits
from cordicc.targets.target import Target

UNITS = ("rotate", "vector", "lightcone", "implicit")
_ADDERS = ("add", "sub", "min", "max", "select", "wrap")
_KINDS = {"mul": "mul", "cmul": "cmul", "shift": "shift", **dict.fromkeys(_ADDERS, "add")}
AREA_STEP = 10
"""Areas are counted in tenths of an adder equivalent."""

_GUARD_BITS = 3
"""At the least, where they are chosen by the accuracy later."""


@dataclass(frozen=True, slots=True)
class Costs:
    """Latency in cycles and area in tenths of adders by kind of unit.

    `implicit`: implicit CAUs may be used; else such an operation is a chain of three standard ones, or of
    two if one of its coefficients is 0.  `words`: how numbers are rounded, with as many guard bits as there
    may be; `coarsest`: the same with the fewest.  `preferred`: few standard CAUs come before every goal.
    """

    latency: dict[str, int]
    area: dict[str, int]
    implicit: bool = True
    words: Words = field(default_factory=Words)
    coarsest: Words = field(default_factory=Words)
    preferred: bool = False

    @classmethod
    def of(cls, target: Target, *, implicit: bool, preferred: bool = False) -> Costs:
        """Return the costs on a target, whose implicit CAUs may be used or not, or are preferred."""
        latency = {kind: unit.latency for kind, unit in target.units.items()}
        area = {kind: round(unit.area * AREA_STEP) for kind, unit in target.units.items()}
        fewest, most = _words(target)
        return cls(latency, area, implicit, most, fewest, implicit and preferred)

    @property
    def floating(self) -> bool:
        """Tell whether numbers have exponents, so that values may be scaled by common denominators."""
        return not self.words.fixed

    def caus(self, op: str, zero_coefficient: bool = False) -> int:
        """Return how many CAUs an operation takes."""
        if op == "implicit" and not self.implicit:
            return 2 if zero_coefficient else 3
        return 1 if op in UNITS else 0

    def cycles(self, op: str, caus: int) -> int:
        """Return the latency of an operation of so many CAUs."""
        if caus:
            kind = "implicit" if op == "implicit" and self.implicit else "standard"
            return caus * self.latency[kind]
        return self.latency[_KINDS.get(op, "sign")] if op not in ("input", "const") else 0

    def size(self, op: str, caus: int) -> int:
        """Return the area of an operation of so many CAUs."""
        if caus:
            kind = "implicit" if op == "implicit" and self.implicit else "standard"
            return caus * self.area[kind]
        return self.area[_KINDS.get(op, "sign")] if op not in ("input", "const") else 0


def _words(target: Target) -> tuple[Words, Words]:
    """Return the words of a target, with as few guard bits as it may have and with as many."""
    system = target.machine().system
    if not isinstance(system, FixedSystem):
        return Words(), Words()
    width, most = system.width_bits, system.guard_bits
    fewest = most
    if target.guard_is_open:
        most = most_guard_bits(width)
        fewest = min(_GUARD_BITS, most)
    few, many = (Words(2.0 ** -(width + guard), 2.0**guard, fixed=True) for guard in (fewest, most))
    return few, many


def of_graph(graph: Graph, costs: Costs, goal: str) -> tuple[int, ...]:
    """Return what a graph of unit operations costs, the first goal first."""
    live = graph.live()
    finish = [0] * len(graph.nodes)
    processors = standard = multipliers = area = 0
    for index, node in enumerate(graph.nodes):
        units = costs.caus(node.op, any(graph.constant(v) == 0 for v in node.operands[:2]))
        start = max((finish[v.node] for v in node.operands), default=0)
        finish[index] = start + costs.cycles(node.op, units)
        if index in live:
            processors += units
            standard += units if node.op != "implicit" else 0
            multipliers += node.op == "mul"
            area += costs.size(node.op, units)
    latency = max(finish[v.node] for v in graph.outputs.values())
    goals = ordered(goal, processors, multipliers, latency, area)
    return (standard, *goals) if costs.preferred else goals


def ordered(goal: str, processors: Any, multipliers: Any, latency: Any, area: Any) -> tuple[Any, ...]:
    """Return figures in the order of a goal, as `--minimize` defines it."""
    if goal == "latency":
        return latency, processors, multipliers, area
    if goal == "area":
        return area, processors, multipliers, latency
    return processors, multipliers, latency, area
