"""The checks of a file: expressions that are 0 where the delivered outputs are perfect.

A check is read as an equation under a name that no user can write, so that vectors, frames and branches mean
in it what they mean in equations.  Its value is made in a graph of its own, in which the outputs are inputs:
the words that were delivered.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from cordicc.base.diagnostics import Report, Span
from cordicc.expressions.lexer import MAX_NAME, ExpressionError
from cordicc.expressions.syntax import Sum, parse_expression
from cordicc.frontend.document.yamltree import NodeKind, YamlNode
from cordicc.frontend.plain.context import EquationContext
from cordicc.frontend.plain.define import define_equations
from cordicc.frontend.plain.plain_equation import CHECK, ParsedEquation
from cordicc.frontend.plain.vectors import Vectors, component_names, uses_vectors
from cordicc.frontend.reading import check_keys, check_name, read_constant, read_mapping, read_text, wanted
from cordicc.frontend.scope import MAX_ERRORS, LimitedBuilder, Scope, Text
from cordicc.frontend.solving.zero import ZeroTest
from cordicc.frontend.trees import relocated
from cordicc.ir.graph import Builder, Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.problem import Check, OutputSpec
from cordicc.ir.ranges.forward import value_ranges

_FORM = "write 'name: expression' lines such as 'px: l1*cos(q1) + l2*cos(q1 + q2) - x'"
_KEYS = ("value", "max", "unit")
_KNOWN = "a check may use inputs, constants, outputs and other names that equations define"
_FARTHEST = 1e9
"""An output without an enclosure is taken to be within this."""

_RESIDUAL = "solve."
"""Before the unknowns of a `solve` whose residual is a check without being asked for: no name has a dot."""


@dataclass(frozen=True, slots=True)
class WrittenChecks:
    """The checks of a file before names are looked up.

    `equations` are those of all checks and of their shared parts; `options` has, by the place of its name,
    what is said of a check.
    """

    equations: tuple[ParsedEquation, ...] = ()
    options: Mapping[Span, Check] = field(default_factory=dict)


def parse_checks(node: YamlNode | None, context: EquationContext) -> WrittenChecks:
    """Return the checks of the mapping `node`; malformed ones are reported."""
    report = context.report
    equations: list[ParsedEquation] = []
    options: dict[Span, Check] = {}
    taken = Scope(Builder(), report)
    pairs = [] if node is None else read_mapping(node, "'checks'", _FORM, report)
    for key, value in pairs:
        if report.errors >= MAX_ERRORS:
            break
        if check_name(key, taken):
            taken.define(key.value, None, key.span.line)
            written, limit, unit = _options(key, value, context)
            if written is not None:
                options[key.span] = Check(key.value, " ".join(written.value.split()), unit, limit)
                equations += _equations(key, written, context)
    return WrittenChecks(tuple(equations), options)


def _options(
    key: YamlNode, node: YamlNode, context: EquationContext
) -> tuple[YamlNode | None, Fraction | None, str | None]:
    """Return the value, the limit and the unit of a check; no value after a diagnostic."""
    report = context.report
    value: YamlNode | None = node
    limit, unit = None, None
    if node.kind is NodeKind.MAPPING:
        entries = check_keys(node, _KEYS, report)
        limit_node, unit_node = entries.get("max"), entries.get("unit")
        if limit_node is not None:
            limit = read_constant(limit_node, "'max'", context.scope, context.places)
            if limit is not None and limit <= 0:
                report.error("E215", "'max' must be greater than 0", limit_node.span)
        if unit_node is not None:
            unit = read_text(unit_node, "'unit'", report, MAX_NAME)
        value = entries.get("value")
    if value is None:
        report.error("E208", f"the check '{key.value}' has no value", key.span, _FORM)
    elif value.kind is not NodeKind.SCALAR or value.is_null:
        report.error("E202", wanted(f"the check '{key.value}'", "an expression", value), value.span, _FORM)
        value = None
    return value, limit, unit


def _equations(key: YamlNode, node: YamlNode, context: EquationContext) -> list[ParsedEquation]:
    """Return a check as an equation, one for each component of a vector, and those of shared parts."""
    text, target = Text(node, context.places), CHECK + key.value
    written = " ".join(node.value.split())
    try:
        expr = parse_expression(node.value, vectors=True)
    except ExpressionError as error:
        text.report(context.report, _with_hint(error))
        return []
    if not uses_vectors(expr, context.vectors):
        return [ParsedEquation(target, key.span, written, (expr, text), hidden=True)]
    make = context.expansion(node, target)
    try:
        found = Vectors(context.vectors, make).expand(relocated(expr, text))
        parts = [(target, found)] if not isinstance(found, tuple) else []
        if isinstance(found, tuple):
            parts = list(zip(component_names(target, len(found)), found, strict=True))
        equations = [make.equation(name, part, key.span, written, hidden=True) for name, part in parts]
    except ExpressionError as error:
        make.text.report(context.report, error)
        return []
    return [*make.hidden, *equations]


def _with_hint(error: ExpressionError) -> ExpressionError:
    """Return a mistake in a check; of a relation, with the hint how it is written."""
    if error.code != "E118" or error.hint is not None:
        return error
    hint = "a check is an expression that is 0: write the left side minus the right side"
    return ExpressionError(error.code, error.message, error.start, error.end, hint)


@dataclass(frozen=True, slots=True)
class FoundChecks:
    """The checks and the graph of their values, and the names of the file that they rest on."""

    checks: tuple[Check, ...] = ()
    graph: Graph = field(default_factory=lambda: Graph((), {}))
    uses: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class CheckReader:
    """Makes the values of checks over the delivered outputs.

    `scope` has what the names of the file mean, `parsed` are all equations and checks with branches chosen,
    `inputs` and `outputs` their names; `ranges` gives those of both.
    """

    scope: Scope
    parsed: Sequence[ParsedEquation]
    inputs: frozenset[str]
    outputs: Mapping[str, OutputSpec]
    ranges: Callable[[], Mapping[str, tuple[float, float]]]

    @property
    def _equations(self) -> list[ParsedEquation]:
        return [equation for equation in self.parsed if not equation.of_check]

    def read(self, written: WrittenChecks) -> FoundChecks:
        """Return the checks that are asked for and the residuals of solves; mistakes are reported."""
        asked, residuals = [e for e in self.parsed if e.of_check], self._residuals()
        made = [*asked, *(equation for equation, _ in residuals)]
        if not made:
            return FoundChecks()
        scope, lost = self._delivered(made)
        scope.outside = dict.fromkeys((check.name for check in written.options.values()), "a check")
        define_equations(made, scope, ZeroTest(scope.builder, {}), {})
        found = self._asked(written, asked, scope, lost)
        for equation, check in residuals:
            value = scope.values.get(equation.target)
            if value is not None:
                found[check.name] = check, value
            elif missing := sorted(equation.names & lost):
                message = f"the residual is not checked: {_no_value(missing[0])}"
                self.scope.report.warning("W110", message, equation.span)
        graph = scope.builder.build({name: value for name, (_, value) in found.items()})
        uses = frozenset(name for equation in made for name in equation.uses)
        return FoundChecks(tuple(check for check, _ in found.values()), _without_origins(graph), uses)

    def _residuals(self) -> list[tuple[ParsedEquation, Check]]:
        """Return the residuals of the solves whose unknowns are all delivered, as equations and checks."""
        found = []
        for equation in self._equations:
            request = equation.request
            if request is None or self.scope.values.get(equation.target) is None:
                continue
            if equation.target != request.unknowns[-1] or not self.outputs.keys() >= set(request.unknowns):
                continue
            for number, (relation, text) in enumerate(request.equations, 1):
                name, written = _RESIDUAL + ".".join(request.unknowns), f"residual of {equation.written}"
                if len(request.equations) > 1:
                    name, written = f"{name}.{number}", f"{written}, equation {number}"
                sides = Sum((relation.left, relation.right), (1, -1), relation.at)
                made = ParsedEquation(CHECK + name, equation.span, written, (sides, text), hidden=True)
                found.append((made, Check(name, written, asked=False)))
        return found

    def _delivered(self, made: Iterable[ParsedEquation]) -> tuple[Scope, frozenset[str]]:
        """Return what names mean where outputs are what was delivered, and those that have no value then."""
        mine = self.scope
        scope = Scope(LimitedBuilder(), Report(), unknown=_KNOWN)
        for name in mine.lines:
            if name not in self.inputs and name not in self.outputs:
                continue
            scope.define(name, scope.builder.input(name), mine.lines[name])
        needed = self._needed(made)
        again = [e for e in self._equations if e.target in needed and mine.values.get(e.target) is not None]
        later = {name for equation in again for name in (equation.target, equation.label)}
        for name, value in mine.values.items():
            if name not in scope.values and name not in later:
                number = None if value is None else mine.builder.constant(value)
                known = None if number is None else scope.builder.const(number)
                scope.define(name, known, mine.lines.get(name, 0))
        ranges = self.ranges() if any(equation.request for equation in again) else {}
        define_equations(again, scope, ZeroTest(scope.builder, ranges), {})
        scope.report = mine.report
        return scope, frozenset(e.target for e in again if scope.values.get(e.target) is None)

    def _needed(self, made: Iterable[ParsedEquation]) -> set[str]:
        """Return the names whose equations are needed, as far as the outputs."""
        known = {equation.target: equation for equation in self._equations}
        todo = [name for equation in made for name in equation.names]
        needed: set[str] = set()
        while todo:
            name = todo.pop()
            if name in known and name not in needed and name not in self.outputs:
                needed.add(name)
                todo += known[name].names
        return needed

    def _asked(
        self, written: WrittenChecks, equations: Sequence[ParsedEquation], scope: Scope, lost: frozenset[str]
    ) -> dict[str, tuple[Check, Value]]:
        """Return the checks of the file by name, with their values; mistakes are reported."""
        report = self.scope.report
        delivered = self._delivered_nodes(scope.builder)
        found: dict[str, tuple[Check, Value]] = {}
        empty: dict[Span, bool] = {}
        for equation in equations:
            name, value = equation.target.removeprefix(CHECK), scope.values.get(equation.target)
            if missing := sorted(equation.names & lost):
                report.error("E217", f"the check has no value: {_no_value(missing[0])}", equation.span)
            if value is None or "." in name:  # shared parts have a dot
                continue
            if not delivered[value.node]:
                empty.setdefault(equation.span, True)
                continue
            empty[equation.span] = False
            if name in found:
                message = f"the check '{name}' is there twice, once as a part or branch of another one"
                report.error("E204", message, equation.span, "use a new name")
            option = replace(written.options[equation.span], name=name, text=equation.written)
            found[name] = option, value
        for span in (span for span, nothing in empty.items() if nothing):
            hint = "it compares inputs with one or more of " + ", ".join(self.outputs)
            message = f"the check '{written.options[span].name}' depends on no output"
            report.error("E216", message, span, hint)
        return found

    def _delivered_nodes(self, builder: Builder) -> list[bool]:
        """Return of each node whether it depends on an output."""
        found: list[bool] = []
        for node in builder.nodes:
            own = node.op == "input" and node.name in self.outputs
            found.append(own or any(found[operand.node] for operand in node.operands))
        return found


def delivered_ranges(
    outputs: Iterable[OutputSpec], program: Graph, inputs: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Return an interval of each input and output, given the graph that delivers and the ranges of inputs."""
    box = {name: Interval(*ends) for name, ends in inputs.items()}
    known = {node.name for node in program.nodes if node.op == "input"} <= box.keys()
    enclosures = value_ranges(program, box) if known else []
    found = dict(inputs)
    for spec in outputs:
        value = program.outputs.get(spec.name)
        interval = None if value is None or not known else enclosures[value.node][value.result]
        if spec.wrap or interval is None:
            interval = Interval(-math.pi, math.pi)
        found[spec.name] = max(interval.lo, -_FARTHEST), min(interval.hi, _FARTHEST)
    return found


def _no_value(name: str) -> str:
    return f"the equation of '{name.partition('.')[0]}' cannot be solved where the outputs are rounded"


def _without_origins(graph: Graph) -> Graph:
    """Return a graph whose nodes are of no equation: they are none of the plan's."""
    return Graph(tuple(replace(node, origin="") for node in graph.nodes), graph.outputs)
