"""A problem file to a `Problem`: every mistake in it is reported at once."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Report, Source, Span
from cordicc.base.files import read_bytes
from cordicc.expressions.lexer import MAX_NAME, ExpressionError
from cordicc.expressions.syntax import names, parse_expression
from cordicc.frontend.assumptions import check_on_box, check_on_samples, read_assumptions
from cordicc.frontend.checks import CheckReader, WrittenChecks, delivered_ranges, parse_checks
from cordicc.frontend.document.yamltree import MAX_BYTES, NodeKind, Places, YamlNode, read_tree
from cordicc.frontend.input_units import InputUnits, shown
from cordicc.frontend.outputs import OutputReader
from cordicc.frontend.plain.alternatives import ALL, with_alternatives
from cordicc.frontend.plain.context import EquationContext
from cordicc.frontend.plain.define import SPLIT, Defined, define_equations
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.read_items import parse_equations
from cordicc.frontend.reading import (
    check_keys,
    check_name,
    read_constant,
    read_mapping,
    read_text,
    wanted,
)
from cordicc.frontend.samples import read_samples
from cordicc.frontend.scope import MAX_ERRORS, LimitedBuilder, Scope, TooManyError
from cordicc.frontend.solving.zero import ZeroTest
from cordicc.ir.facts import InputFacts
from cordicc.ir.problem import InputSpec, OutputSpec, Problem, SampleTable
from cordicc.plan.plain_data import FORMAT

KEYS = (
    "name", "description", "constants", "inputs", "equations", "outputs", "samples", "assume", "branches",
    "checks",
)  # fmt: skip
MAX_DESCRIPTION = 10_000
NO_STATE = (
    "; there is no state: one sample knows nothing of the one before, feed in as an input what is kept of it"
)


@dataclass(frozen=True, slots=True)
class LoadedProblem:
    """A valid problem, the warnings about it, and its text."""

    problem: Problem
    warnings: tuple[Diagnostic, ...]
    source: Source


def load_problem(path: str | os.PathLike[str]) -> LoadedProblem:
    """Read a problem file.

    Raises InvalidInput with all the errors of the file, ordered by place.
    """
    file = Path(path)
    source, bom = _read_source(file)
    return _parse(source, file.parent, bom)


def parse_problem(source: Source, base: Path | None = None) -> LoadedProblem:
    """Return the problem of a text; samples are looked up in `base`.  Raises InvalidInput."""
    return _parse(source, base, False)


def _read_source(file: Path) -> tuple[Source, bool]:
    """Return the text of a file, and whether a byte order mark was removed from it."""
    name = str(file)

    def fail(code: str, message: str, hint: str | None = None, source: Source | None = None) -> InvalidInput:
        return InvalidInput([Diagnostic(code, message, None, hint, source=source or Source(name, ""))])

    try:
        data = read_bytes(file, MAX_BYTES)
    except FileNotFoundError:
        raise fail("E100", "there is no such file") from None
    except IsADirectoryError:
        raise fail("E100", "this is a directory, not a problem file") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise fail("E100", f"the file cannot be read: {reason}") from None
    if len(data) > MAX_BYTES:
        raise fail("E100", f"the file is larger than {MAX_BYTES >> 20} MiB")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise fail("E100", "the file is UTF-16", "save it as UTF-8")
    bom = data.startswith(b"\xef\xbb\xbf")
    data = data[3:] if bom else data
    try:
        return Source(name, data.decode("utf-8")), bom
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = len(data[data.rfind(b"\n", 0, error.start) + 1 : error.start].decode("utf-8", "replace")) + 1
        source = Source(name, data.decode("utf-8", "replace"))
        span = Span(line, column, column + 1)
        message = f"the file is not UTF-8: byte 0x{data[error.start]:02X}"
        raise InvalidInput([Diagnostic("E100", message, span, "save it as UTF-8", source=source)]) from None


def _parse(source: Source, base: Path | None, bom: bool) -> LoadedProblem:
    report = Report(source)
    if bom:
        report.warning("W101", "the byte order mark at the start of the file is ignored")
    root = read_tree(source, report)
    if root is None:
        raise InvalidInput(report.ordered())
    problem = None
    try:
        problem = _Loader(Places(source), report, base).load(root)
    except TooManyError as error:
        report.error("E104", str(error), None, SPLIT)
    if report.failed or problem is None:
        shown = report.first(MAX_ERRORS)
        if report.errors >= MAX_ERRORS:
            shown.append(Diagnostic("E299", f"only the first {MAX_ERRORS} errors are shown", source=source))
        raise InvalidInput(shown)
    return LoadedProblem(problem, tuple(report.first(MAX_ERRORS)), source)


class _Loader:
    def __init__(self, places: Places, report: Report, base: Path | None) -> None:
        self.places = places
        self.report = report
        self.base = base
        self.scope = Scope(LimitedBuilder(), report)
        self.constants: dict[str, Fraction] = {}
        self.inputs: list[InputSpec] = []
        self.all_branches = False
        self.input_spans: dict[str, Span] = {}
        self.units = InputUnits(report)

    def full(self) -> bool:
        return self.report.errors >= MAX_ERRORS

    def load(self, root: YamlNode) -> Problem | None:
        if root.kind is not NodeKind.MAPPING:
            hint = "it has the keys " + ", ".join(KEYS)
            self.report.error("E202", wanted("a problem file", "a mapping", root), root.span, hint)
            return None
        if any(key.value == "format" and value.value == FORMAT for key, value in root.pairs):
            hint = "cordicc simulate, explain, draw and diff take plans"
            self.report.error("E202", "this is a plan, not a problem file", root.pairs[0][0].span, hint)
            return None
        parts = check_keys(root, KEYS, self.report)
        name = self.read_name(parts.get("name"))
        description = parts.get("description")
        about = (
            (read_text(description, "'description'", self.report, MAX_DESCRIPTION) or "")
            if description
            else ""
        )
        self.all_branches = self.read_branches(parts.get("branches"))
        self.read_constants(parts.get("constants"), parts.get("inputs"))
        self.read_inputs(parts.get("inputs"), root)
        ranges = {spec.name: (float(spec.lo), float(spec.hi)) for spec in self.inputs}
        defined, parsed, written = self.read_equations(parts, root, ranges)
        reader = OutputReader(self.scope, self.places, defined)
        outputs, values = reader.read(parts.get("outputs"))
        samples, facts = self.read_facts(parts, defined)
        program = self.scope.builder.build(values)
        delivered = {spec.name: spec for spec in outputs}
        of_both = partial(delivered_ranges, outputs, program, ranges)
        checks = CheckReader(self.scope, parsed, frozenset(ranges), delivered, of_both).read(written)
        if self.report.failed:
            return None
        self.warn_unused(defined, outputs, checks.uses)
        self.units.finish(root, program, self.inputs, self.input_spans)
        return Problem(
            name, about.strip(), self.constants, tuple(self.inputs), tuple(defined.equations), outputs,
            program, samples, facts, checks.checks, checks.graph,
        )  # fmt: skip

    def read_name(self, node: YamlNode | None) -> str:
        if node is None or node.is_null:
            stem = re.sub(r"[^\w.+-]", "_", Path(self.report.source.name if self.report.source else "").stem)
            return stem.lstrip(".") or "problem"
        text = read_text(node, "'name'", self.report, MAX_NAME)
        if text is not None and (
            not text.strip() or text.startswith(".") or re.search(r"[/\\\x00-\x1f]", text)
        ):
            hint = "use letters, digits, '-' and '_'"
            self.report.error("E202", "the name must be usable as the name of a folder", node.span, hint)
        return text or ""

    def read_constants(self, node: YamlNode | None, inputs: YamlNode | None) -> None:
        if node is None:
            return
        pairs = read_mapping(node, "'constants'", "write 'name: number' lines", self.report)
        if inputs is not None:
            self.scope.outside = {key.value: "an input" for key, _ in inputs.pairs}
        self.scope.later = {key.value: (key.span.line, _uses(value)) for key, value in reversed(pairs)}
        for key, value in pairs:
            if self.full():
                return
            if not check_name(key, self.scope):
                continue
            number = read_constant(value, f"the constant '{key.value}'", self.scope, self.places, key.value)
            self.scope.later.pop(key.value, None)
            constant = None if number is None else self.scope.builder.const(number)
            self.scope.define(key.value, constant, key.span.line)
            if number is not None:
                self.constants[key.value] = number
        self.scope.outside, self.scope.later = {}, {}

    def read_inputs(self, node: YamlNode | None, root: YamlNode) -> None:
        form = "write 'name: [low, high]' lines such as 'x: [0, 1]'"
        if node is None:
            self.report.error("E208", "'inputs' is missing", root.span, form)
            return
        pairs = read_mapping(node, "'inputs'", form, self.report)
        if not pairs and not self.report.failed:
            self.report.error("E208", "there are no inputs", node.span, form)
        self.scope.outside = {key.value: "an input" for key, _ in pairs if key.value not in self.scope.lines}
        specs: list[tuple[YamlNode, InputSpec | None]] = []
        for key, value in pairs:
            if self.full():
                break
            if check_name(key, self.scope):
                specs.append((key, self.read_input(key.value, value)))
        self.scope.outside = {}
        for key, spec in specs:
            # an input without a valid range is an input nevertheless: its uses are fine
            self.scope.define(key.value, self.scope.builder.input(key.value), key.span.line)
            self.input_spans[key.value] = key.span
            if spec is not None:
                self.inputs.append(spec)

    def read_input(self, name: str, node: YamlNode) -> InputSpec | None:
        unit, unit_node = None, None
        span_node: YamlNode | None = node
        if node.kind is NodeKind.MAPPING:
            entries = check_keys(node, ("range", "unit"), self.report)
            unit_node, span_node = entries.get("unit"), entries.get("range")
            unit = read_text(unit_node, "'unit'", self.report, MAX_NAME) if unit_node is not None else None
            if span_node is None:
                self.report.error("E208", f"the input '{name}' has no range", node.span)
                return None
        assert span_node is not None
        if span_node.kind is not NodeKind.SEQUENCE or len(span_node.items) != 2:
            message = f"the range of '{name}' must be [low, high]"
            self.report.error("E211", message, span_node.span, "every input needs a closed range")
            return None
        lo, hi = (
            read_constant(item, f"an end of the range of '{name}'", self.scope, self.places)
            for item in span_node.items
        )
        if lo is None or hi is None:
            return None
        scale = self.units.scale(name, None if unit is None else unit_node, span_node.items, (lo, hi))
        if lo > hi:
            message = f"the range of '{name}' is empty: {shown(lo)} > {shown(hi)}"
            self.report.error("E211", message, span_node.span)
            return None
        return InputSpec(name, lo, hi, unit, scale)

    def read_equations(
        self, parts: Mapping[str, YamlNode], root: YamlNode, ranges: Mapping[str, tuple[float, float]]
    ) -> tuple[Defined, list[ParsedEquation], WrittenChecks]:
        """Return what the equations define, and them and the checks with a branch chosen for each."""
        node = parts.get("equations")
        if node is None:
            self.report.error("E208", "'equations' is missing", root.span)
            return Defined(), [], WrittenChecks()
        all_ranges = {name: ranges.get(name, (0.0, 1.0)) for name in self.scope.lines}
        self.scope.unknown = "define it above, or list it under 'inputs' with its range, or under 'constants'"
        self.scope.no_state = NO_STATE
        context = EquationContext(self.scope, self.places, all_branches=self.all_branches)
        written = parse_equations(node, context)
        checks = parse_checks(parts.get("checks"), context)
        parsed, variants = with_alternatives([*written, *checks.equations], self.report)
        zeros = ZeroTest(self.scope.builder, all_ranges)
        defined = define_equations([e for e in parsed if not e.of_check], self.scope, zeros, variants)
        for name in dict.fromkeys(zeros.given_up.values()):
            message = f"a coefficient in '{name}' seems to be 0, but is too large for a proof: it is computed"
            hint = "simplify the equation by hand if the coefficient cancels"
            self.report.warning("W107", message, defined.spans.get(name), hint)
        self.scope.unknown, self.scope.no_state = None, ""
        return defined, parsed, checks

    def read_branches(self, node: YamlNode | None) -> bool:
        """Return whether every solve is wanted with both branches."""
        if node is None or node.is_null:
            return False
        if node.kind is not NodeKind.SCALAR or node.value != ALL:
            hint = "leave 'branches' out, or write 'branches: all' for both branches of every solve"
            self.report.error("E307", "'branches' can only be 'all'", node.span, hint)
        return True

    def read_facts(
        self, parts: Mapping[str, YamlNode], defined: Defined
    ) -> tuple[SampleTable | None, InputFacts]:
        """Return the samples and the assumptions, checked against one another."""
        samples = None
        if (node := parts.get("samples")) is not None:
            samples = read_samples(node, self.base, self.inputs, self.report)
        if (node := parts.get("assume")) is None or node.is_null:
            return samples, InputFacts()
        scope = Scope(LimitedBuilder(), self.report)
        made = [*defined.uses, *defined.labels.values()]
        scope.outside = dict.fromkeys(made, "defined by an equation")
        known = [name for name in self.scope.lines if name not in scope.outside]
        for name in known:
            number = self.constants.get(name)
            failed = number is None and self.scope.values[name] is None
            value = scope.builder.input(name) if number is None else scope.builder.const(number)
            scope.define(name, None if failed else value, self.scope.lines[name])
        facts, spans = read_assumptions(node, scope, self.places)
        if self.report.failed:
            return samples, facts
        if samples is not None:
            check_on_samples(facts, spans, samples, self.report)
        else:
            check_on_box(facts, spans, self.inputs, self.report)
        return samples, facts

    def warn_unused(self, defined: Defined, outputs: tuple[OutputSpec, ...], checked: frozenset[str]) -> None:
        todo = [*(spec.name for spec in outputs), *sorted(checked)]
        needed = set(todo)
        while todo:
            fresh = defined.uses.get(todo.pop(), frozenset()) - needed
            needed |= fresh
            todo.extend(fresh)
        for equation in defined.equations:
            if needed.isdisjoint(defined.members.get(equation.target, [equation.target])):
                message = f"'{equation.target}' is not needed for any output"
                self.report.warning("W102", message, defined.spans[equation.target])
        for spec in self.inputs:
            if spec.name not in needed:
                message = f"the input '{spec.name}' is not used"
                self.report.warning("W103", message, self.input_spans[spec.name])


def _uses(node: YamlNode) -> frozenset[str]:
    """Return the names in a constant's expression, none if it is malformed."""
    try:
        return frozenset(n.name for n in names(parse_expression(node.value)))
    except ExpressionError:
        return frozenset()
