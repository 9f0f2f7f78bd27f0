"""A problem as read: what the equations mean, before any rewriting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from cordicc.ir.facts import Assumption, InputFacts
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.sampling import Workspace


@dataclass(frozen=True, slots=True)
class InputSpec:
    """An input and its closed range, in metres and radians where units are converted; `unit` is a label.

    `scale` is what one of the unit is, if the file gives the range in it: then the range is shown in it.
    """

    name: str
    lo: Fraction
    hi: Fraction
    unit: str | None = None
    scale: Fraction | None = None


@dataclass(frozen=True, slots=True)
class Equation:
    """An equation as written: the name it defines, its text, and the line it starts on.

    A vector or frame is one equation under its own name, which is the origin of the nodes of all its
    entries; so is each unknown of a solve, and each choice of its branch.
    """

    target: str
    text: str
    line: int


@dataclass(frozen=True, slots=True)
class OutputSpec:
    """An output: whether it is an angle, whether it is delivered in (-pi, pi], the error asked for."""

    name: str
    is_angle: bool = False
    wrap: bool = False
    max_error: Fraction | None = None


@dataclass(frozen=True, slots=True)
class SampleTable:
    """Rows of the true workspace, by column: every input, equally many finite numbers each."""

    file: str
    columns: Mapping[str, tuple[float, ...]]

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.columns.values()), ()))


@dataclass(frozen=True, slots=True)
class Check:
    """An expression that is 0 where the delivered outputs are perfect.

    `max` is the largest magnitude allowed, if any; `unit` is documentation only.  One that nobody `asked`
    for is the residual of a `solve`, left side minus right side.
    """

    name: str
    text: str
    unit: str | None = None
    max: Fraction | None = None
    asked: bool = True


@dataclass(frozen=True, slots=True)
class Problem:
    """The equations of a file as data.

    `graph` holds every input, in order of declaration, and the outputs as they are delivered:
    an angle with `wrap` is wrapped there.  The `facts` have a graph of their own, so that passes over
    `graph` need not renumber them.  `check_graph` has the checks as its outputs; its inputs are those of the
    problem and the outputs, which stand for the words that were delivered.
    """

    name: str
    description: str
    constants: Mapping[str, Fraction]
    inputs: tuple[InputSpec, ...]
    equations: tuple[Equation, ...]
    outputs: tuple[OutputSpec, ...]
    graph: Graph
    samples: SampleTable | None = None
    facts: InputFacts = field(default_factory=InputFacts)
    checks: tuple[Check, ...] = ()
    check_graph: Graph = field(default_factory=lambda: Graph((), {}))

    @property
    def assumptions(self) -> tuple[Assumption, ...]:
        """Return what is assumed of the inputs."""
        return self.facts.items

    @property
    def workspace(self) -> Workspace:
        """Return where samples of the inputs are drawn from."""
        ranges = {item.name: (float(item.lo), float(item.hi)) for item in self.inputs}
        return Workspace(ranges, None if self.samples is None else self.samples.columns)

    def input(self, name: str) -> InputSpec:
        """Return the input of that name; raises KeyError."""
        for spec in self.inputs:
            if spec.name == name:
                return spec
        raise KeyError(name)

    def output(self, name: str) -> OutputSpec:
        """Return the output of that name; raises KeyError."""
        for spec in self.outputs:
            if spec.name == name:
                return spec
        raise KeyError(name)


def input_intervals(problem: Problem) -> dict[str, Interval]:
    """Return the range of each input: the doubles at its ends belong to it."""
    return {spec.name: Interval(float(spec.lo), float(spec.hi)) for spec in problem.inputs}
