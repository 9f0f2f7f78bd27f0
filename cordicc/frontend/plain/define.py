"""The equations of a file, taken in order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cordicc.base.diagnostics import Span
from cordicc.frontend.lower import ANGLE, LinearForm, linear_form, lower_all
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.scope import MAX_ERRORS, Scope, TooManyError
from cordicc.frontend.solving.loops import solve_loop
from cordicc.frontend.solving.solve import solve
from cordicc.frontend.solving.zero import ZeroTest
from cordicc.ir.graph import Value
from cordicc.ir.problem import Equation

SPLIT = "divide it into several files"


@dataclass(slots=True)
class Defined:
    """What the equations define, in order.

    `labels` has the vector or frame of each name that is one of several of an item, `members` the
    names of each; `order`, `forms` and `targets` have the hidden names too.
    """

    equations: list[Equation] = field(default_factory=list)
    uses: dict[str, frozenset[str]] = field(default_factory=dict)
    forms: dict[str, LinearForm] = field(default_factory=dict)
    spans: dict[str, Span] = field(default_factory=dict)
    targets: list[str] = field(default_factory=list)
    order: dict[str, int] = field(default_factory=dict)
    labels: dict[str, str] = field(default_factory=dict)
    members: dict[str, list[str]] = field(default_factory=dict)
    variants: Mapping[str, list[str]] = field(default_factory=dict)

    def with_siblings(self, names: set[str]) -> set[str]:
        """Return names with all others of the items to which they belong."""
        labels = {self.labels[name] for name in names if name in self.labels}
        return names | {name for name, label in self.labels.items() if label in labels}


def define_equations(
    parsed: Sequence[ParsedEquation], scope: Scope, zeros: ZeroTest, variants: Mapping[str, list[str]]
) -> Defined:
    """Add the names the equations define to the scope, and return what is known of them.

    `variants` are the names that a name with several branches stands for.
    """
    defined = Defined(variants=variants)
    scope.later = {}
    for equation in reversed(parsed):
        for name in (equation.target, equation.label):
            if name and not equation.hidden and name not in scope.lines:
                scope.later[name] = (equation.span.line, equation.uses)
    for name, clones in variants.items():
        scope.later.setdefault(name, scope.later.get(clones[0], (0, frozenset())))
    refused: set[Span] = set()
    for equation in parsed:
        if scope.report.errors >= MAX_ERRORS:
            break
        scope.builder.origin = equation.label or equation.target
        if not equation.hidden and not _announce(equation, scope, defined, refused):
            continue
        try:
            value, form = _value(equation, scope, zeros)
        except TooManyError as error:
            scope.report.error("E104", str(error), equation.span, SPLIT)
            break
        target = equation.target
        scope.later.pop(target, None)
        defined.order[target] = len(defined.targets)
        defined.targets.append(target)
        defined.forms[target] = form or LinearForm()
        if equation.hidden:
            scope.values[target] = value
            continue
        scope.define(target, value, equation.span.line)
        defined.uses[target] = equation.uses
        defined.spans[target] = equation.span
    scope.builder.origin = ""
    return defined


def _announce(equation: ParsedEquation, scope: Scope, defined: Defined, refused: set[Span]) -> bool:
    """Note the item of an equation when its first part comes; report names that are taken."""
    label, line = equation.label or equation.target, equation.span.line
    if equation.span in refused and equation.label:
        return False
    first = defined.spans.get(label) != equation.span
    if equation.label and first:
        if not scope.check_new(label, equation.span, line):
            refused.add(equation.span)
            return False
        scope.define(label, None, line)
        scope.later.pop(label, None)
        defined.spans[label] = equation.span
    if not scope.check_new(equation.target, equation.span, line):
        return False
    if first:
        defined.equations.append(Equation(label, equation.written, line))
    if equation.label:
        defined.labels[equation.target] = label
        defined.members.setdefault(label, []).append(equation.target)
    return True


def _value(equation: ParsedEquation, scope: Scope, zeros: ZeroTest) -> tuple[Value | None, LinearForm | None]:
    if equation.request is not None and equation.request.together:
        pair = solve_loop(equation.request, scope, zeros)
        if pair is None:
            return None, None
        return pair[equation.request.together.index(equation.target)], ANGLE
    if equation.request is not None:
        solved = solve(equation.request, scope, zeros)
        if solved is None:
            return None, None
        return solved[0], ANGLE if solved[1] == 1 else None
    if equation.definition is None:
        return None, None
    expr, text = equation.definition
    values = lower_all(expr, scope, text, equation.target)
    if values[id(expr)] is None:
        return None, None
    return values[id(expr)], linear_form(expr, values, scope.builder)
