"""What the names of a problem file mean, and the diagnostics about names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from fractions import Fraction
from itertools import islice

from cordicc.base.diagnostics import Report, Span
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import CONSTANT_NAMES, FUNCTIONS, Name, Place
from cordicc.frontend.document.yamltree import Places, YamlNode
from cordicc.ir.graph import Builder, Param, Value
from cordicc.ir.meaning.exact import DEG, PI

MAX_ERRORS = 100
MAX_MADE = 50_000
"""Operations that the expressions of a file may ask for, those that cancel included."""

_MOST_COMPARED = 200
_LONGEST_MISSPELT = 60
"""Names that a misspelt one is compared with, and its characters."""

BUILT_IN: dict[str, Fraction] = {"pi": PI, "deg": DEG}


@dataclass(frozen=True, slots=True)
class Text:
    """An expression's scalar, and how its offsets become places in the file."""

    node: YamlNode
    places: Places

    def span(self, at: Place) -> Span:
        """Return the place in the file of a stretch of the expression."""
        return self.places.within(self.node, *at)

    def report(self, report: Report, error: ExpressionError) -> None:
        """Record a mistake in the expression."""
        report.error(error.code, error.message, self.span((error.start, error.end)), error.hint)


@dataclass(frozen=True, slots=True)
class FileText(Text):
    """An expression put together from several scalars; its places are offsets into the file."""

    def span(self, at: Place) -> Span:
        """Return the place in the file of a stretch of it."""
        return self.places.span(*at)


class TooManyError(Exception):
    """The expressions of a file ask for more than MAX_MADE operations."""

    def __str__(self) -> str:
        return f"the problem has more than {MAX_MADE} operations"


class LimitedBuilder(Builder):
    """A builder of no more than MAX_MADE operations; beyond, it raises TooManyError."""

    def emit(self, op: str, operands: Iterable[Value] = (), params: Iterable[Param] = ()) -> Value:
        """Return the first result of the operation, adding it if it is new."""
        value = super().emit(op, operands, params)
        if value.node >= MAX_MADE:
            raise TooManyError
        return value


@dataclass(slots=True)
class Scope:
    """The names known so far.

    `values` maps a name to its value; a name whose definition failed is there with None, so that
    its uses are not reported.  `later` has the names that equations further down define, with the
    names each of them uses; `outside` says of names that exist but cannot be used here what they are;
    `unknown` is the hint for names that are like no other, `no_state` what is added to that for a circle.
    """

    builder: Builder
    report: Report
    values: dict[str, Value | None] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)
    later: dict[str, tuple[int, frozenset[str]]] = field(default_factory=dict)
    outside: Mapping[str, str] = field(default_factory=dict)
    unknown: str | None = None
    no_state: str = ""
    cycles_reported: set[frozenset[str]] = field(default_factory=set)

    def define(self, name: str, value: Value | None, line: int) -> None:
        """Add a name; None marks one whose definition failed."""
        self.values[name] = value
        self.lines.setdefault(name, line)

    def lookup(self, name: Name, text: Text, target: str | None) -> Value | None:
        """Return the value of a name used in the definition of `target`; None after a diagnostic."""
        if name.name in self.values:
            return self.values[name.name]
        if name.name in CONSTANT_NAMES:
            return self.builder.const(BUILT_IN[name.name])
        if self.report.errors >= MAX_ERRORS:
            return None
        if name.name in self.outside:
            message = f"'{name.name}' is {self.outside[name.name]} and cannot be used here"
            self.report.error("E212", message, text.span(name.at))
        elif name.name in self.later:
            self._report_early(name, text, target)
        else:
            self.report.error(
                "E203", f"unknown name '{name.name}'", text.span(name.at), self._hint(name.name)
            )
        return None

    def _hint(self, name: str) -> str | None:
        if name == "valid":
            return "'valid' is made by the compiler and cannot be used in equations"
        known = [known for known in self.values if "." not in known]  # those of the compiler have a dot
        near = did_you_mean(name, [*known, *CONSTANT_NAMES])
        return near or self.unknown

    def _report_early(self, name: Name, text: Text, target: str | None) -> None:
        if any({name.name, target} <= cycle for cycle in self.cycles_reported):
            return
        cycle = shortest_path(name.name, target, {n: uses for n, (_, uses) in self.later.items()})
        if cycle and target is not None:
            members = frozenset(cycle)
            if members not in self.cycles_reported:
                self.cycles_reported.add(members)
                shown = " -> ".join([target, *cycle])
                hint = "definitions take effect in their order: eliminate by hand what makes the circle"
                self.report.error(
                    "E206", f"cyclic dependency: {shown}", text.span(name.at), hint + self.no_state
                )
            return
        line = self.later[name.name][0]
        message = f"'{name.name}' is used before it is defined (line {line})"
        self.report.error("E205", message, text.span(name.at), "definitions take effect in their order")

    def check_new(self, name: str, span: Span, line: int) -> bool:
        """Report whether a name may be defined here."""
        kind = "a function" if name in FUNCTIONS else "a constant" if name in CONSTANT_NAMES else None
        if name == "valid":
            kind = "the output that marks invalid samples"
        if kind:
            self.report.error("E207", f"'{name}' is {kind} and cannot be redefined", span)
            return False
        if name in self.lines:
            message = f"'{name}' is defined twice, first on line {self.lines[name]}"
            hint = "a name has one definition; use a new name" if line else None
            self.report.error("E204", message, span, hint)
            return False
        return True


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name nearest to a misspelt one, if there is one.

    Of many names only those of about the same length and with the same ends are looked at.
    """
    known = list(known)
    same = next((k for k in known if k.lower() == name.lower()), None)
    if same is not None or len(name) > _LONGEST_MISSPELT:
        return same
    if len(known) > _MOST_COMPARED:
        alike = (
            k for k in known if abs(len(k) - len(name)) <= 2 and k[:1] == name[:1] and k[-1:] == name[-1:]
        )
        known = list(islice(alike, _MOST_COMPARED))
    near = get_close_matches(name, known, 1, 0.6)
    return near[0] if near else None


def did_you_mean(name: str, known: Iterable[str]) -> str | None:
    """Return a hint with the known name nearest to a misspelt one, if there is one."""
    near = nearest(name, known)
    return f"did you mean '{near}'?" if near else None


def shortest_path(start: str, goal: str | None, edges: Mapping[str, frozenset[str]]) -> list[str]:
    """Return the names on a shortest way from `start` to `goal`, both included; empty if there is none."""
    if goal is None:
        return []
    before: dict[str, str | None] = {start: None}
    front = [start]
    while front and goal not in before:
        following = []
        for name in front:
            for used in sorted(edges.get(name, ())):
                if used not in before:
                    before[used] = name
                    following.append(used)
        front = following
    if goal not in before:
        return []
    path: list[str] = []
    step: str | None = goal
    while step is not None:
        path.append(step)
        step = before[step]
    return path[::-1]
