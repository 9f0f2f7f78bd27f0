"""Where the accuracy of a plan ends: near inputs at which a quotient is one of two results that vanish.

Both results err there by as much as anywhere else, and their quotient by that over the denominator.  Random
samples seldom come near enough to show it, so the plan is run on the way to zeros of its denominators, on
inputs that are words of the target.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cordicc.base.arrays import Floats, Samples
from cordicc.base.diagnostics import Diagnostic, Severity
from cordicc.emulate import functional
from cordicc.emulate.histogram import angular
from cordicc.emulate.observation import reference_samples
from cordicc.emulate.ports import as_words
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.doubles import screen, values_of
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ranges.forward import value_ranges
from cordicc.ir.sampling import DEFAULT_SEED, draw
from cordicc.ir.zeros import Approaches, approaches
from cordicc.plan.model import Plan
from cordicc.plan.stated_accuracy import AccuracyEnd, SeenErrors

_SHARES = 2.0 ** -np.arange(37.0)
"""Of a way from a zero to a sample: where the plan is looked at."""

_SAMPLES = 2_000
"""Drawn samples, from which ways lead to zeros, and which show how large outputs are."""

_WAYS, _FEWEST = 24, 6
"""Ways to the zeros of a denominator, and how few do where a problem is large."""

_WORK = 60_000
"""Operations on arrays that the last resort of the search for zeros of all denominators may take."""

_LOOKED_AT = 5_000
"""Operations, counted anew for each denominator that they lead to, with which zeros are looked for."""

_REACH = 2.0**-10
"""Of the usual size of a denominator: rows of the problem's own samples that come so near to a zero do so."""

_USUAL, _ALLOWED = 0.99, 8.0
"""An output is wrong where it errs by this many times what so many of the default samples are within."""

_ROUNDING = 2.0**-20
"""Of an output's largest value, an error that is not wrong in any case."""

_GROWN = 4.0
"""Times that error is what it must come to nearer to the zero."""

_BOUNDED = 4.0
"""Times its largest value is what an output may be: beyond, it has a pole there."""

_LEAST = 4
"""Samples of an octave of sizes, of which most are wrong: with fewer nothing is said."""

_AROUND = 16.0
"""Times the size at which most samples are wrong: single ones up to there are put down to it too."""

Near = Approaches | dict[str, Floats]
"""Ways to zeros, or the rows of the problem's own samples that come near to one."""


def with_ends(plan: Plan) -> tuple[Plan, list[Diagnostic]]:
    """Return an observed plan that states where the accuracy of its outputs ends, and warnings of it."""
    denominators = _denominators(plan)
    if not denominators:
        return plan, []
    run = _Run.of(plan)
    sizes = np.cumsum([len(plan.problem.program.live([each.value])) for each in denominators])
    count = int(np.searchsorted(sizes, _LOOKED_AT, side="right"))
    near = [(each, points) for each in denominators[:count] if (points := run.near(each, count))]
    ways = reference_samples(plan.problem.program) // _SHARES.size
    looked_at = near[: ways // _FEWEST]
    left = [each for each, _ in near[ways // _FEWEST :]] + denominators[count:]
    warnings = []
    ends: dict[str, list[AccuracyEnd]] = {name: [] for name in plan.accuracy}
    for denominator, points in looked_at:
        found = run.judged(denominator, points, min(_WAYS, ways // len(looked_at)))
        if found:
            warnings.append(_told(denominator, found))
        for name, end in found.items():
            ends[name].append(end)
    if left:
        warnings.append(_left_out(left[0]))
    accuracy = {name: replace(figures, ends=tuple(ends[name])) for name, figures in plan.accuracy.items()}
    return replace(plan, accuracy=accuracy), warnings


@dataclass(frozen=True, slots=True)
class _Denominator:
    """A denominator without constant factors: its value, the nodes that divide by it, names.

    `name` is its own, if it has one, `equations` are those that divide by it.
    """

    value: Value
    users: frozenset[int]
    name: str
    equations: tuple[str, ...]

    @property
    def equation(self) -> str:
        """The equations in words."""
        many = "equation" if len(self.equations) == 1 else "equations"
        return f"{many} of {_listed(self.equations)}"


def _listed(names: Iterable[str]) -> str:
    """Return names in quotes as a sentence lists them."""
    *first, last = (f"'{name}'" for name in names)
    return f"{', '.join(first)} and {last}" if first else last


def _denominators(plan: Plan) -> list[_Denominator]:
    """Return the denominators that are not proven to be never 0."""
    program = plan.problem.program
    ranges = value_ranges(program, {item.name: Interval(item.lo, item.hi) for item in plan.problem.inputs})
    users: dict[Value, list[int]] = {}
    for index, node in enumerate(program.nodes):
        if node.op == "div" or (node.op == "pow" and node.exponent < 0):
            value = _without_factors(program, node.operands[-1])
            enclosure = ranges[value.node][value.result]
            if enclosure is not None and enclosure.lo <= 0 <= enclosure.hi:
                users.setdefault(value, []).append(index)
    found = []
    for value, nodes in users.items():
        equations = tuple(dict.fromkeys(program.nodes[index].origin for index in nodes))
        found.append(_Denominator(value, frozenset(nodes), _name(plan, value, equations), equations))
    return found


def _without_factors(program: Graph, value: Value) -> Value:
    """Return what a value is a constant multiple of."""
    while True:
        node = program.node(value)
        varying = [operand for operand in node.operands if program.constant(operand) is None]
        product = node.op == "mul" or (node.op == "div" and varying == [node.operands[0]])
        if len(varying) != 1 or not (product or node.op == "neg"):
            return value
        value = varying[0]


def _name(plan: Plan, value: Value, users: tuple[str, ...]) -> str:
    """Return the name of an input or of what another equation makes; empty for a value without one."""
    program = plan.problem.program
    node = program.node(value)
    if node.op == "input":
        return node.name
    # The last operation of an equation of numbers is what it defines.
    last = max(index for index, other in enumerate(program.nodes) if other.origin == node.origin)
    plain = any(e.target == node.origin and "[" not in e.text for e in plan.problem.equations)
    return node.origin if plain and last == value.node and node.origin not in users else ""


@dataclass(frozen=True, slots=True)
class _Run:
    """A plan, samples, and by output its largest value there and the error that is wrong."""

    plan: Plan
    samples: dict[str, Floats]
    largest: Mapping[str, float]
    allowed: Mapping[str, float]

    @classmethod
    def of(cls, plan: Plan) -> _Run:
        drawn = draw(plan.problem.workspace, _SAMPLES, DEFAULT_SEED)
        samples = plan.problem.facts.among(drawn)
        values, defined = screen(plan.problem.program, samples)
        largest = {
            name: float(np.max(np.abs(column[defined]), initial=0.0)) for name, column in values.items()
        }
        wanted = {output.name: output.max_error for output in plan.problem.outputs}
        allowed = {
            name: wanted[name] or max(_ALLOWED * _usual(figures.observed), _ROUNDING * largest[name])
            for name, figures in plan.accuracy.items()
            if figures.observed.max is not None
        }
        return cls(plan, samples, largest, allowed)

    def near(self, denominator: _Denominator, among: int) -> Near | None:
        """Return where a denominator, one of so many, comes near to 0; None if nowhere."""
        problem = self.plan.problem
        if problem.samples is None:
            graph = problem.program.leading_to(denominator.value)
            return approaches(graph, problem.workspace.ranges, self.samples, _WAYS, _WORK // among)
        rows = {name: np.asarray(column, dtype=np.float64) for name, column in problem.samples.items()}
        sizes = self.sizes(denominator, rows)
        usable = np.flatnonzero(np.isfinite(sizes) & (sizes > 0))
        if not usable.size or sizes[usable].min() > _REACH * np.median(sizes[usable]):
            return None
        order = usable[np.argsort(sizes[usable], kind="stable")]
        return {name: column[order] for name, column in rows.items()}

    def sizes(self, denominator: _Denominator, samples: Samples) -> Floats:
        """Return the size of a denominator on samples."""
        program = self.plan.problem.program
        order = sorted(program.live([denominator.value]))
        return np.abs(values_of(program.nodes, order, samples)[denominator.value.node])

    def judged(self, denominator: _Denominator, near: Near, ways: int) -> dict[str, AccuracyEnd]:
        """Return by output where its accuracy ends, of those that depend on a denominator."""
        program = self.plan.problem.program
        if isinstance(near, Approaches):
            points = near.points(_SHARES, ways)
        else:
            points = {name: column[: ways * _SHARES.size] for name, column in near.items()}
        samples = self._words(points)
        outputs = functional.run(self.plan, self.plan.arithmetic, samples)
        values, defined = reference_outputs(program, samples)
        good = defined & outputs["valid"].astype(bool) & self.plan.problem.facts.kept(samples)
        sizes = self.sizes(denominator, samples)
        found = {}
        for name, is_angle in self.plan.problem.angles.items():
            rests = program.live([program.outputs[name]])
            if name not in self.allowed or denominator.users.isdisjoint(rests):
                continue
            used = good & (sizes > 0) & (np.abs(values[name]) <= _BOUNDED * self.largest[name])
            errors = angular(outputs[name][used] - values[name][used], is_angle)
            at = {input: column[used] for input, column in samples.items()}
            end = _end(denominator, sizes[used], errors, self.allowed[name], at)
            if end is not None:
                found[name] = end
        return found

    def _words(self, points: Samples) -> dict[str, Floats]:
        """Return samples that are words of the target, in the ranges where these are."""
        words = as_words(self.plan, points)
        return {item.name: np.clip(words[item.name], item.lo, item.hi) for item in self.plan.problem.inputs}


def _usual(seen: SeenErrors) -> float:
    """Return an error that `_USUAL` of the samples are within, up to a factor of 2."""
    least = _USUAL * sum(count for _, count in seen.histogram)
    for lower, count in seen.histogram:
        least -= count
        if least <= 0:
            return 2 * lower
    return 0.0


def _end(
    denominator: _Denominator, sizes: Floats, errors: Floats, allowed: float, samples: Samples
) -> AccuracyEnd | None:
    """Return where accuracy ends, given sizes of a denominator and errors of an output on samples.

    It ends at the largest size at which a sample is wrong, around the octave of sizes in which most are.
    """
    if not sizes.size:
        return None
    octaves = np.frexp(sizes)[1]
    found, place, count = np.unique(octaves, return_inverse=True, return_counts=True)
    wrong = np.bincount(place, errors > allowed, found.size)
    most = np.flatnonzero((2 * wrong >= count) & (count >= _LEAST))
    if not most.size:
        return None
    half = math.ldexp(1.0, int(found[most[-1]]))
    here = (errors > allowed) & (sizes <= _AROUND * half)
    worst = int(np.argmax(np.where(here, errors, -np.inf)))
    if errors[worst] < _GROWN * allowed:
        return None
    at = {name: float(column[worst]) for name, column in samples.items()}
    below = _rounded_up(float(sizes[here].max()))
    return AccuracyEnd(denominator.equation, denominator.name, below, allowed, float(errors[worst]), at)


def _rounded_up(number: float) -> float:
    """Return a positive number rounded up to two digits."""
    step = 10.0 ** (math.floor(math.log10(number)) - 1)
    return float(f"{math.ceil(number / step) * step:.2g}")


def _told(denominator: _Denominator, found: Mapping[str, AccuracyEnd]) -> Diagnostic:
    """Return the warning of a denominator near a zero of which outputs are wrong."""
    output, end = max(found.items(), key=lambda each: each[1].worst / each[1].error)
    below = max(each.below for each in found.values())
    message = (
        f"a quotient of two small results in the {denominator.equation}: where {end.size} is below "
        f"{below:.2g}, {_listed(found)} may be wrong by more than {end.error:.2g}"
    )
    at = ", ".join(f"{name} = {number:.6g}" for name, number in end.at.items())
    hint = (
        f"'{output}' is by {end.worst:.2g} at {at}; keep the ranges away from there, multiply the "
        "denominator out, or write the quotient as its series: sin(x)/x is 1 - x**2/6 + x**4/120"
    )
    return Diagnostic("W418", message, None, hint, Severity.WARNING)


def _left_out(denominator: _Denominator) -> Diagnostic:
    message = f"denominators from the {denominator.equation} on are not looked at: the problem is large"
    return Diagnostic("W322", message, None, None, Severity.WARNING)
