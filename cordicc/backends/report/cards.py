"""What the report tells of each box of the pictures when it is pointed at: typeset, in a few lines."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from markupsafe import Markup

from cordicc.backends import labels
from cordicc.backends.palette import LOOKS
from cordicc.backends.report.unit_accuracy import own_errors
from cordicc.backends.text.formulas import Formulas
from cordicc.backends.text.mathml import Formula, name
from cordicc.plan.model import Fifo, Operation, Plan
from cordicc.plan.netlist import Connection, FifoEnd, Netlist
from cordicc.plan.origin import PlanInput


@dataclass(frozen=True, slots=True)
class About:
    """A card: the id of the box, a title, formulas, and pairs of a heading and what is to be said."""

    id: str
    title: str
    formulas: tuple[Markup, ...] = ()
    facts: tuple[tuple[str, Markup | str], ...] = ()
    steps: tuple[str, ...] = ()


@dataclass(slots=True)
class Cards:
    """The cards of a plan, with what they share."""

    plan: Plan
    formulas: Formulas = field(init=False)
    errors: dict[str, str] = field(init=False)
    netlist: Netlist = field(init=False)

    def __post_init__(self) -> None:
        self.formulas = Formulas(self.plan)
        self.errors = own_errors(self.plan)
        self.netlist = Netlist.of(self.plan)

    def all(self) -> list[About]:
        """Return a card for each input, operation, FIFO and output."""
        inputs = [_input(each) for each in self.plan.problem.inputs]
        operations = [self._operation(each) for each in self.plan.operations]
        fifos = [self._fifo(each) for each in self.plan.fifos]
        return [*inputs, *operations, *fifos, *(self._output(each) for each in self.plan.outputs)]

    def order(self) -> list[str]:
        """Return the ids of the boxes in the order of time, for walking from one to the next."""
        timed = [(-1, 0, f"in.{each}") for each in self.plan.problem.input_names]
        timed += [(o.start, 2, f"op.{o.id}") for o in self.plan.operations]
        timed += [(begin, 1, f"fifo.{each}") for each, (begin, _) in self.netlist.spans.items()]
        timed += [(self.plan.latency_cycles, 3, f"out.{each}") for each in self.plan.outputs]
        return [box for _, _, box in sorted(timed, key=lambda item: item[:2])]

    def _operation(self, operation: Operation) -> About:
        kind = LOOKS[operation.kind].label if operation.kind in LOOKS else operation.kind
        facts: list[tuple[str, Markup | str]] = [
            ("Unit", f"{operation.unit}, {kind}"),
            ("Cycles", self._cycles(operation.start, operation.finish)),
            ("Operands", self._operands(operation)),
            ("Results", self._results(operation)),
        ]
        if operation.equation:
            facts.insert(0, ("From the equation of", math(name(operation.equation))))
        if operation.id in self.errors:
            facts.append(("Own error", self.errors[operation.id]))
        if operation.end_error is not None:
            facts.append(("Angle near |C| = R", labels.end_of_reach(operation)))
        title = f"{operation.id}: {labels.function(operation)}"
        formulas = tuple(math(each) for each in self.formulas.of(operation))
        return About(f"op.{operation.id}", title, formulas, tuple(facts), operation.derivation)

    def _cycles(self, begin: int, end: int) -> str:
        clock = self.plan.clock_hz
        if begin == end:
            return f"in cycle {begin}, without taking one"
        return f"{begin} to {end}, {labels.seconds(begin, clock)} to {labels.seconds(end, clock)}"

    def _operands(self, operation: Operation) -> Markup:
        listed = []
        wired = self.netlist.operands[operation.id]
        for port, item, connection in zip(operation.ports, operation.operands, wired, strict=False):
            shown = self.formulas.operand(item) if item.value is None else self.formulas.symbol(item.value)
            listed.append(Markup("{} = {}{}").format(port, math(shown), _through(connection, " ")))
        return Markup("; ").join(listed)

    def _results(self, operation: Operation) -> Markup:
        listed = []
        for value in operation.results:
            if value is None:
                continue
            point = self.plan.formats.values.get(value)
            bits = f" ({point.width} bits, {point.fraction} of them fraction bits)" if point else ""
            listed.append(Markup("{}{}").format(math(self.formulas.symbol(value)), bits))
        return Markup("; ").join(listed)

    def _fifo(self, fifo: Fifo) -> About:
        begin, end = self.netlist.spans[fifo.id]
        words = f"{fifo.depth} {'word' if fifo.depth == 1 else 'words'} of {fifo.width} bits"
        return About(
            f"fifo.{fifo.id}",
            f"{fifo.id}: FIFO of {words}",
            (),
            (
                ("Delays", math(self.formulas.symbol(fifo.value))),
                ("Cycles", self._cycles(begin, end)),
                ("From", fifo.source),
                ("To", ", ".join(fifo.sinks)),
            ),
        )

    def _output(self, output: str) -> About:
        item = self.plan.outputs[output]
        known = self.plan.accuracy.get(output)
        source = self.formulas.operand(item) if item.value is None else None
        facts: list[tuple[str, Markup | str]] = [
            ("Value", math(source) if source is not None else str(item.value)),
            (
                "Leaves in",
                f"cycle {self.plan.latency_cycles}{_through(self.netlist.outputs[output], ', ')}",
            ),
            ("Largest error seen", figure(known.observed.max if known else None)),
            ("Proven bound", figure(known.bound.value if known and known.bound else None)),
        ]
        return About(f"out.{output}", f"output {output}", (), tuple(facts))


def _through(connection: Connection, before: str) -> str:
    """Say which FIFO a value waits in, after some text, if it does."""
    driver = connection.driver
    return f"{before}through FIFO {driver.fifo}" if isinstance(driver, FifoEnd) else ""


def _input(item: PlanInput) -> About:
    shown = labels.shown_range(item)
    ends = " to ".join(labels.constant(str(end)) for end in (shown.lo, shown.hi))
    facts = (("Range", f"{ends} {shown.unit}".rstrip()), ("Accepted in", "cycle 0"))
    return About(f"in.{item.name}", f"input {item.name}", (), facts)


def math(formula: Formula) -> Markup:
    """Return a formula as HTML that needs no escaping any more."""
    return Markup(formula.html())


def figure(value: Any) -> str:
    """Write an error, or say that there is none."""
    return f"{float(value):.3g}" if isinstance(value, (int, float)) else "none"
