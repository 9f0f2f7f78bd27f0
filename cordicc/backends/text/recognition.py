"""Which operations each equation became, and why they compute it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.backends import labels
from cordicc.backends.text.formulas import Formulas
from cordicc.backends.text.mathml import Formula
from cordicc.ir.ops import Level
from cordicc.plan.model import Operation, Plan
from cordicc.targets.target import CAU_KINDS


@dataclass(frozen=True, slots=True)
class RecognisedUnit:
    """A CAU of an equation: formulas, and sentences on why, formulas in them between backticks."""

    operation: Operation
    formulas: tuple[Formula, ...]
    why: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Recognised:
    """An equation: the name it defines, its text, its CAUs, others with steps, and the rest in words."""

    target: str
    text: str
    units: tuple[RecognisedUnit, ...]
    others: tuple[RecognisedUnit, ...]
    rest: str


def recognised(plan: Plan, formulas: Formulas) -> list[Recognised]:
    """Return the equations in order, then what belongs to none of them, if there is anything."""
    functions = _functions(plan)
    groups: dict[str, list[Operation]] = {}
    for operation in plan.operations:
        groups.setdefault(operation.equation, []).append(operation)
    texts = {equation.target: equation.text for equation in plan.problem.equations}
    others = [name for name in groups if name not in texts]
    made = []
    for target in [*texts, *others]:
        group = groups.get(target, [])
        units = [each for each in group if each.kind in CAU_KINDS]
        small = [each for each in group if each.kind not in CAU_KINDS]
        told = [each for each in small if each.derivation]
        made.append(
            Recognised(
                target,
                texts.get(target, ""),
                tuple(
                    RecognisedUnit(each, formulas.of(each), _why(each, functions.get(target, frozenset())))
                    for each in units
                ),
                tuple(RecognisedUnit(each, formulas.of(each), each.derivation) for each in told),
                _rest(group, small),
            )
        )
    return made


def _functions(plan: Plan) -> dict[str, frozenset[str]]:
    """Return the functions in each equation as written, by the name it defines."""
    found: dict[str, set[str]] = {}
    for node in plan.problem.program.nodes:
        if node.definition.level is Level.FUNCTION:
            found.setdefault(node.origin, set()).add(node.op)
    return {origin: frozenset(ops) for origin, ops in found.items()}


def _rest(group: Sequence[Operation], small: Sequence[Operation]) -> str:
    """Say what else an equation takes."""
    if not group:
        return "No operation of its own: what it says is part of the operations of other equations."
    counts = Counter(each.kind for each in small)
    names = [
        f"{counts[kind]} {labels.plain_kind(kind)}{'s' * (counts[kind] > 1)}"
        for kind in sorted(counts, key=labels.kind_rank)
    ]
    return f"{'Besides' if len(small) < len(group) else 'By'} {', '.join(names)}." if names else ""


def _why(operation: Operation, functions: frozenset[str]) -> tuple[str, ...]:
    """Return sentences on what a CAU stands for, then the steps that were recorded."""
    write = {"implicit": _implicit, "vector": _vector, "rotate": _rotate, "lightcone": _lightcone}
    first = write[operation.op](operation, functions) if operation.op in write else ()
    return (*first, *operation.derivation)


def _implicit(operation: Operation, functions: frozenset[str]) -> tuple[str, ...]:
    m = operation.m
    c, s = ("cos", "sin") if m == 1 else ("cosh", "sinh")
    form = f"`B*{c}(theta) + A*{s}(theta) = C`"
    inverse = {1: ("acos", "asin"), -1: ("acosh", "asinh")}.get(m or 0, ("", ""))
    said = []
    if "solve" in functions or "solve_pair" in functions:
        said.append(f"The equation has the form {form}, which an implicit CAU solves in one pass.")
    elif inverse[0] in functions:
        said.append(
            f"`{inverse[0]}(C/B)` is the angle with `B*{c}(theta) = C`: an implicit CAU solves that in one "
            "pass, without the quotient."
        )
    elif inverse[1] in functions:
        said.append(
            f"`{inverse[1]}(C/A)` is the angle with `A*{s}(theta) = C`: an implicit CAU solves that in one "
            "pass, without the quotient."
        )
    else:
        said.append(f"The value solves an equation of the form {form}, one pass of an implicit CAU.")
    if operation.results[1] is not None:
        rest = "A**2 + B**2 - C**2" if m == 1 else "A**2 - B**2 + C**2"
        said.append(f"The same pass leaves `sqrt({rest})`, which is used too.")
    return tuple(said)


def _vector(operation: Operation, functions: frozenset[str]) -> tuple[str, ...]:
    m = operation.m
    if m == 0:
        return ("Vectoring in linear coordinates is a division: `y/x`.",)
    sign, angle = ("+", "atan2(y, x)") if m == 1 else ("-", "atanh(y/x)")
    parts = {0: f"`sqrt(x**2 {sign} y**2)`", 1: f"`{angle}`"}
    used = [parts[i] for i, value in enumerate(operation.results) if value is not None]
    both = ", both in one pass" if len(used) > 1 else ""
    return (f"Turning the vector `[x, y]` to the axis gives {' and '.join(used)}{both}.",)


def _rotate(operation: Operation, functions: frozenset[str]) -> tuple[str, ...]:
    m = operation.m
    if m == 0:
        return ("Rotation in linear coordinates is a product and a sum: `y + x*z`.",)
    c, s = ("cos", "sin") if m == 1 else ("cosh", "sinh")
    sign = "-" if m == 1 else "+"
    return (
        f"Turning the vector `[x, y]` by `z` gives `x*{c}(z) {sign} y*{s}(z)` and `y*{c}(z) + x*{s}(z)`.",
    )


def _lightcone(operation: Operation, functions: frozenset[str]) -> tuple[str, ...]:
    parts = {0: "`sqrt(u*v)`", 1: "`log(u/v)/2`"}
    used = [parts[i] for i, value in enumerate(operation.results) if value is not None]
    return (f"Hyperbolic vectoring of `[(u + v)/2, (u - v)/2]` gives {' and '.join(used)}.",)
