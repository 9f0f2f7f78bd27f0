"""Words and symbols for what a plan holds, shared by the pictures and the report."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from cordicc.backends.palette import LOOKS
from cordicc.expressions.quantities import base_unit, unit_meant
from cordicc.plan.model import Fifo, Operand, Operation, Plan
from cordicc.plan.origin import PlanInput
from cordicc.plan.stated_accuracy import StatedBound
from cordicc.targets.target import CAU_KINDS

SYMBOLS = {
    "add": "+", "sub": "−", "mul": "×", "neg": "−1×", "abs": "|a|", "sign": "sgn", "min": "min", "max": "max",
    "flip": "±", "select": "sel", "guard": "ok?", "wrap": "mod 2π", "vector": "vector", "rotate": "rotate",
    "lightcone": "light cone", "implicit": "implicit",
}  # fmt: skip
KIND_ORDER = ("standard", "implicit", "mul", "cmul", "add", "shift", "sign")


def kind_rank(kind: str) -> tuple[int, str]:
    """Return the sort key of a unit kind: CAUs first, kinds of a user's target last."""
    return (KIND_ORDER.index(kind) if kind in KIND_ORDER else len(KIND_ORDER), kind)


def plain_kind(kind: str) -> str:
    """Return the name of a kind in words."""
    return LOOKS[kind].label.partition(",")[0] if kind in LOOKS else kind


MOST = "99 %"
"""The share of valid samples whose own bounds are shown."""


def most_within(bound: StatedBound | None) -> float | None:
    """Return the bound within which the own bounds of so many samples are, if a plan states one."""
    return None if bound is None or bound.own_bounds is None else bound.own_bounds.get("0.99")


def turned_down(plan: Plan) -> str:
    """Say for which checks cheaper operations were turned down."""
    names = ", ".join(f"'{name}'" for name in plan.selection.turned_down)
    return f"cheaper operations were turned down: rounding would move {names} too far from 0"


def constant(text: str) -> str:
    """Write a constant of the plan to six significant digits; text of another form stays."""
    try:
        value = float.fromhex(text) if "0x" in text.lower() else float(Fraction(text))
    except (ValueError, OverflowError, ZeroDivisionError):
        return text
    return f"{value:.6g}".replace("-", "−")


class ShownRange(NamedTuple):
    """The range of an input as it is shown: numbers in the unit of its label, and the unit."""

    lo: float
    hi: float
    unit: str


def shown_range(item: PlanInput) -> ShownRange:
    """Return the range of an input in the unit of the file; samples are in metres or radians."""
    if item.scale is None or item.unit is None:
        return ShownRange(item.lo, item.hi, item.unit or "")
    lo, hi = (float(f"{end / item.scale:.12g}") for end in (item.lo, item.hi))
    meant = unit_meant(item.unit)
    samples = "" if item.scale == 1 or meant is None else f", samples in {base_unit(meant)}"
    return ShownRange(lo, hi, item.unit + samples)


def operand(item: Operand) -> str:
    """Write an operand: the value's name or the constant as it is."""
    return str(item.value if item.value is not None else item.constant)


def symbol(operation: Operation) -> str:
    """Return the short sign of an operation, its constants included."""
    if operation.op == "cmul":
        return "× " + constant(str(operation.params.get("factor", "k")))
    if operation.op == "shift":
        return _shift(str(operation.params.get("exponent", "")))
    base = SYMBOLS.get(operation.op, operation.op)
    fixed = [None if item.constant is None else constant(item.constant) for item in operation.operands]
    if len(fixed) == 2 and any(fixed):
        return _with_constant(operation.op, base, *fixed)
    return base


def _with_constant(op: str, base: str, first: str | None, second: str | None) -> str:
    """Write a two-operand operation with a constant operand; a + -c becomes - c."""
    if op == "sub" and second is None:
        return f"{first} − a"
    number = second if second is not None else str(first)
    if op in ("add", "sub") and number.startswith("−"):
        return f"{'+' if op == 'sub' else '−'} {number[1:]}"
    return f"{base} {number}" if op in ("add", "sub", "mul", "min", "max") else base


def _shift(exponent: str) -> str:
    try:
        places = int(exponent)
    except ValueError:
        return "shift"
    return f"<< {places}" if places >= 0 else f">> {-places}"


def mode(operation: Operation) -> str:
    """Say which mode of its unit an operation takes."""
    return (operation.mode or operation.op).replace("branch -", "branch −")


def function(operation: Operation) -> str:
    """Say what an operation does, constants of small operations included."""
    words = mode(operation)
    extra = symbol(operation)
    if operation.kind in CAU_KINDS or not operation.params or extra == words:
        return words
    condition = operation.params.get("condition")
    return f"{words}: {condition if condition is not None else extra}"


def end_of_reach(operation: Operation) -> str:
    """Say what an implicit angle is off near |C| = R; empty where that is not reached or not known."""
    error = operation.end_error
    if error is None:
        return ""
    root = "sqrt(R^2 - C^2)" if operation.m == 1 else "sqrt(A^2 - B^2 + C^2)"
    most = "" if error.angle_rad is None else f", at most {error.angle_rad:.3g} rad"
    return f"off by {error.residual:.3g}/{root} rad{most}"


def cycles(operation: Operation) -> str:
    """Write start and finish."""
    if operation.start == operation.finish:
        return f"cycle {operation.start}"
    return f"cycles {operation.start}–{operation.finish}"


def operation_tip(operation: Operation) -> str:
    """Return the tooltip of an operation."""
    ports = [
        f"{port} = {operand(item)}" for port, item in zip(operation.ports, operation.operands, strict=False)
    ]
    params = [f"{name} = {value}" for name, value in sorted(operation.params.items())]
    lines = [
        f"{operation.id}: {function(operation)} on {operation.unit}",
        f"equation: {operation.equation}",
        cycles(operation),
        "operands: " + ", ".join(ports),
        "results: " + ", ".join(name or "not used" for name in operation.results),
    ]
    return "\n".join([*lines, *(["parameters: " + ", ".join(params)] if params else [])])


def fifo_tip(fifo: Fifo) -> str:
    """Return the tooltip of a FIFO."""
    return (
        f"{fifo.id}: {fifo.value}, {fifo.depth} words of {fifo.width} bits\n"
        f"from {fifo.source}\nto {', '.join(fifo.sinks)}"
    )


def duration(seconds: float) -> str:
    """Write a time with a fitting unit."""
    for unit, scale in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= scale:
            return f"{seconds / scale:.4g} {unit}"
    return f"{seconds / 1e-9:.4g} ns"


def seconds(count: float, clock: float) -> str:
    """Write the time of `count` cycles at a clock in Hz with a fitting unit; no cycles need none."""
    return duration(count / clock) if count else "0"


def proof(plan: Plan, name: str) -> str:
    """Say whether a figure (a key of `Plan.optimal`) is proven optimal, else what is proven of it."""
    if plan.optimal.get(name):
        return "proven optimal for these operations"
    bound = plan.bounds.get(name)
    return "no bound" if bound is None else f"at least {bound}"


def needs_effort(plan: Plan) -> bool:
    """Tell whether a larger --effort may find or prove more."""
    searched = not plan.selection.searched or plan.selection.proven
    limited = any("--effort" in words for words in plan.selection.left_out)
    return limited or not searched or not all(plan.optimal.values())


def headline(plan: Plan) -> str:
    """Return target, latency, CAU count and initiation interval in one line."""
    kinds = [unit.kind for unit in plan.units]
    counts = [f"{kinds.count(kind)} {kind}" for kind in CAU_KINDS if kind in kinds]
    total = sum(kind in CAU_KINDS for kind in kinds)
    parts = [
        plan.target.name,
        f"{total} CAU{'' if total == 1 else 's'}" + (f" ({', '.join(counts)})" if counts else ""),
        f"latency {plan.latency_cycles} cycles ({seconds(plan.latency_cycles, plan.clock_hz)})",
        f"initiation interval {plan.initiation_interval}",
        f"{sum(fifo.depth for fifo in plan.fifos)} FIFO words",
    ]
    return " · ".join(part for part in parts if part)
