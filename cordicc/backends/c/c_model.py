"""The plan as a C99 file and its header, which compute the same bits as the emulator.

A plan becomes one function of straight-line code; the operations of units are functions of their own, in
integers of 64 bits, with tables from `cordicc.arith.kernels.shift_sequences`.  Only what the plan uses is
written.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from cordicc.arith.kernels.reduction import LN2_BITS, QuarterTurns
from cordicc.arith.kernels.shift_sequences import ln2_fixed
from cordicc.arith.kernels.thresholds import ROOT_BITS, ROOT_SCALE, ROOTS, SHARE_BITS
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import NumberFormat
from cordicc.arith.unit.arithmetic import Arithmetic, least_exponent
from cordicc.backends.c import c_units as units
from cordicc.backends.c.c_arithmetic import CArithmetic, COperand, conjunction
from cordicc.backends.c.c_fixed import CannotEmit, CFixedPoint
from cordicc.backends.c.c_names import comment, identifiers
from cordicc.backends.c.c_sections import Library, render
from cordicc.backends.c.c_single import CSinglePrecision
from cordicc.backends.labels import shown_range
from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.plan.model import Operand, Operation, Plan, dependence_order
from cordicc.targets.target import CAU_KINDS


def files(plan: Plan) -> dict[str, str]:
    """Return the texts of the C file and its header by file name, NAME.c and NAME.h.

    Raises Unattainable for an operation that has no C form (E420).
    """
    name = identifiers([plan.name])[plan.name]
    try:
        context = _ModelTexts(plan, name).context()
    except CannotEmit as error:
        message = f"the C model of this plan cannot be written: {error}"
        raise Unattainable([Diagnostic("E420", message, hint="wrap: false, or a smaller range")]) from None
    return {f"{name}.c": render("c_model.c.j2", context), f"{name}.h": render("c_model.h.j2", context)}


@dataclass(slots=True)
class _ModelTexts:
    """The texts of a plan's C model."""

    plan: Plan
    name: str
    arithmetic: Arithmetic = field(init=False)
    words: CArithmetic = field(init=False)
    formats: dict[str, NumberFormat] = field(init=False)
    terms: dict[str, COperand] = field(init=False)
    unit_needs: dict[str, None] = field(default_factory=dict)
    quarters: dict[QuarterTurns, str] = field(default_factory=dict)
    """The names of the tables by which angles are reduced, which formats and units share."""

    def __post_init__(self) -> None:
        plan = self.plan
        self.arithmetic = plan.arithmetic
        system = self.arithmetic.system
        assert isinstance(system, (FixedSystem, SingleSystem))
        self.words = CFixedPoint(system) if isinstance(system, FixedSystem) else CSinglePrecision(system)
        inputs = list(plan.problem.input_names)
        results = [name for o in plan.operations for name in o.results if name is not None]
        self.formats = {name: system.format(plan.formats.values.get(name)) for name in (*inputs, *results)}
        members, locals_ = identifiers(inputs), identifiers(results)
        texts = {name: f"in->{members[name]}" for name in inputs} | locals_
        self.terms = {name: COperand(text, self.formats[name]) for name, text in texts.items()}

    def context(self) -> dict[str, Any]:
        """Return what the templates of file and header need."""
        plan, fixed = self.plan, isinstance(self.words, CFixedPoint)
        statements = list(self._statements())
        inputs, outputs = list(self._inputs()), list(self._outputs())
        library = Library()
        phase = units.phase_table(self.words.phases)
        shared = {
            "fixed": fixed,
            "operand_bits": self.arithmetic.system.operand_bits,
            "ln2": (ln2_fixed(LN2_BITS), LN2_BITS),
            "roots": ROOTS,
            "root_scale": ROOT_SCALE,
            "root_scale_bits": ROOT_BITS,
            "share_bits": SHARE_BITS,
            "phase": phase,
            "quarters": list(self.quarters),
            "most_quarters": max((len(table.thresholds) for table in self.quarters), default=0) or 1,
            **self.words.context(),
        }
        library.add("c_model_support.c.j2", "", shared)
        for kind in CAU_KINDS:
            if any(need.startswith(f"{kind}_") for need in self.unit_needs):
                library.add(
                    "c_model_units.c.j2",
                    f"{kind}_",
                    units.unit_context(self.arithmetic.caus[kind], f"{kind}_"),
                )
        return {
            "name": self.name,
            "title": comment(plan.name),
            "target": comment(plan.target.name),
            "description": [comment(line) for line in plan.description.splitlines() if line.strip()],
            "guard": f"CORDICC_{self.name.upper()}_H",
            "fixed": fixed,
            "ctype": self.words.ctype,
            "inputs": inputs,
            "outputs": outputs,
            "statements": statements,
            "functions": library.text([*self.words.needs, *self.unit_needs]),
            "all_valid": conjunction([item["is_valid"] for item in outputs]),
            "reads_inputs": any(item["reads"] for item in inputs),
        }

    def _inputs(self) -> Iterator[dict[str, Any]]:
        used = self._used()
        for at, item in enumerate(self.plan.problem.inputs):
            name = item.name
            format_ = self.formats[name]
            shown = shown_range(item)
            about = [self.words.describe(format_), f"{shown.lo!r} to {shown.hi!r}", shown.unit]
            yield {
                "name": name,
                "member": self.terms[name].text.removeprefix("in->"),
                "comment": comment("; ".join(part for part in about if part)),
                "lo": item.lo,
                "hi": item.hi,
                "encoded": self.words.encode(f"numbers[{at}]", format_),
                "invalid": self.words.invalid(format_),
                "reads": name in used,
            }

    def _outputs(self) -> Iterator[dict[str, Any]]:
        system = self.arithmetic.system
        members = identifiers(self.plan.outputs)
        for name, operand in self.plan.outputs.items():
            format_ = system.format(self.plan.formats.outputs.get(name))
            delivered = COperand(f"out->{members[name]}", format_)
            about = (self.words.describe(format_), self._equation(name))
            yield {
                "name": name,
                "member": members[name],
                "comment": comment("; ".join(part for part in about if part)) or "output",
                "expression": self.words.converted(self._term(operand), format_),
                "is_valid": self.words.is_valid(delivered),
                "invalid": self.words.invalid(format_),
                "decoded": self.words.decode(delivered),
            }

    def _equation(self, name: str) -> str:
        texts = [e.text for e in self.plan.problem.equations if e.target == name]
        return texts[0] if texts else ""

    def _term(self, operand: Operand) -> COperand:
        if operand.value is not None:
            return self.terms[operand.value]
        assert operand.constant is not None
        return self.words.constant(operand.constant)

    def _used(self) -> set[str]:
        """Return the values that something takes, operations counted only where a result is taken."""
        used = {operand.value for operand in self.plan.outputs.values() if operand.value is not None}
        for operation in reversed(dependence_order(self.plan)):
            if used.intersection(operation.results):
                used.update(o.value for o in operation.operands if o.value is not None)
        return used

    def _statements(self) -> Iterator[str]:
        used = self._used()
        for operation in dependence_order(self.plan):
            if not used.intersection(operation.results):
                continue
            yield f"    /* {comment(f'{operation.id}: {operation.mode}, for {operation.equation}')} */"
            terms = [self._term(operand) for operand in operation.operands]
            valid = conjunction([self.words.is_valid(term) for term in terms if not term.constant])
            if operation.kind in CAU_KINDS:
                yield from self._unit_operation(operation, terms, valid, used)
            else:
                yield self._calculation(operation, terms, valid)

    def _calculation(self, operation: Operation, terms: list[COperand], valid: str) -> str:
        (name,) = operation.results
        assert name is not None
        result = self.terms[name]
        value = self.words.calculate(operation.op, operation.settings, terms, result.format)
        if valid != "1":
            value = f"{valid} ? ({value}) : {self.words.invalid(result.format)}"
        return f"    const {self.words.ctype} {result.text} = {value};"

    def _unit_operation(
        self, operation: Operation, terms: list[COperand], valid: str, used: set[str]
    ) -> Iterator[str]:
        section, more = units.function(operation.op, operation.params)
        if section == "rotate_circular":
            quarters = self.arithmetic.quarters(operation.kind, terms[2].format)
            if quarters is None:
                self.words.phases.append(self.words.exponents(terms[2].format))
            else:
                section += "_by_table"
                turns = self.quarters.setdefault(quarters, f"quarters_{len(self.quarters) + 1}")
                self.unit_needs["quarter_tables"] = None
                more = [*more, f"&{turns}"]
            cau = self.arithmetic.caus[operation.kind]
            more = [*more, str(least_exponent(terms[0].format, terms[1].format, cau.operand_bits))]
        function = f"{operation.kind}_{section}"
        self.unit_needs |= {function: None, "nothing": None}
        number = self.plan.operations.index(operation)
        cau = self.arithmetic.caus[operation.kind]
        table = units.slack_table(operation.op, operation.params, operation.slack, cau, f"slack_{number}")
        if table is not None:
            yield f"    {table.declaration}"
            more = [*more, *table.arguments]
        both = f"unit_{number}"
        arguments = ", ".join([*(self.words.unpack(term) for term in terms), *more])
        yield f"    const pair {both} = {valid} ? {function}({arguments}) : nothing;"
        for at, name in enumerate(operation.results):
            if name is not None and name in used:
                result = self.terms[name]
                part = f"{both}.{('first', 'second')[at]}"
                word = self.words.pack(part, result.format, angle=at == operation.angle)
                yield f"    const {self.words.ctype} {result.text} = {word};"
