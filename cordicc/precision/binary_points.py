"""A binary point for every value of a plan on a fixed-point target, from proven ranges.

Ranges are outward-rounded enclosures over the samples for which the equations have a value, tightened by
subdivision where they are loose.  A value whose range cannot be bounded is looked at by trying to make it
large: if it grows past all formats the problem is refused with the input that shows it, otherwise its
format follows what was reached, and a warning says so (a sample beyond is marked invalid).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cordicc.arith.numbers.decimals import nearest_double
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.base.diagnostics import Diagnostic, Severity, Source, Unattainable
from cordicc.emulate.climb import climb, climbing
from cordicc.ir.findings import example_of, place
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.doubles import all_results
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import Problem, input_intervals
from cordicc.ir.ranges.contraction import contracted
from cordicc.ir.ranges.forward import refreshed, value_ranges
from cordicc.ir.ranges.subdivision import Tightness, tightened
from cordicc.ir.sampling import draw_with_corners

_SAMPLES = 400
_WORK = 150_000
_HEADROOM = 1 + 2.0**-12
"""Computed values exceed exact ones a little; a format holds the range times this."""

_LOOSE_BITS = 6
"""Bits that a proven range may cost beyond what was reached before the latter decides."""

_UNPROVEN_HEADROOM = 4.0
_HOPELESS = 2.0**20
"""An unbounded value that is seen to grow to this multiple of its median has no useful format."""

_LAST_OCTAVE = sys.float_info.max_exp - 1
"""Of doubles: a value beyond 2^1023 has no format anyway."""

_CLIMBERS = 16
_CLIMBS = 96


@dataclass(frozen=True, slots=True)
class Magnitudes:
    """By value and output name, what their formats must hold; and the warnings about what is not proven."""

    values: Mapping[Value, float]
    outputs: Mapping[str, float]
    warnings: tuple[Diagnostic, ...]


def magnitudes(problem: Problem, source: Source, graph: Graph) -> Magnitudes:
    """Return what the format of each value must hold.

    Raises:
        Unattainable: a value grows past every format (E412).
    """
    samples = draw_with_corners(problem.workspace, _SAMPLES)
    inputs = {Value(index) for index, node in enumerate(graph.nodes) if node.op == "input"}
    values = [v for v in sorted(graph.used_results() | inputs) if graph.constant(v) is None]
    columns, valid = reference_outputs(Graph(graph.nodes, {str(i): v for i, v in enumerate(values)}), samples)
    seen = {v: np.abs(columns[str(i)][valid]) for i, v in enumerate(values)}
    signs = {v: _sign(columns[str(i)][valid]) for i, v in enumerate(values)}
    enclosures = contracted(graph, value_ranges(graph, input_intervals(problem)))
    enclosures = tightened(graph, enclosures, _goals(graph, seen, signs), _WORK)
    found: dict[Value, float] = {}
    warnings: list[Diagnostic] = []
    for value in values:
        proven = enclosures[value.node][value.result]
        reached = float(np.max(seen[value], initial=0.0))
        bound = 0.0 if proven is None else proven.magnitude
        if proven is not None and bound > reached * 2.0**_LOOSE_BITS:
            bound, warning = _unproven(problem, source, graph, value, samples, seen[value], bound)
            if warning is not None:
                # A sample beyond is invalid from here on, so what follows need not hold it either.
                warnings.append(warning)
                results = list(enclosures[value.node])
                results[value.result] = proven.intersect(Interval(-bound, bound))
                enclosures[value.node] = tuple(results)
                refreshed(graph, graph.downstream(value.node), enclosures)
        found[value] = bound * _HEADROOM
    outputs = {
        name: abs(nearest_double(number)) if (number := graph.constant(value)) is not None else found[value]
        for name, value in graph.outputs.items()
    }
    return Magnitudes(found, outputs, tuple(dict.fromkeys(warnings)))


def formats(
    problem: Problem, source: Source, found: Magnitudes, graph: Graph, system: FixedSystem
) -> dict[Value | str, BinaryPoint]:
    """Return the format of each value, and of each output by name.

    Inputs have words as outside; a value that only leaves has the output's own.  A format is no finer than
    its unit: see `_resolved`.

    Raises:
        Unattainable: a value is too large for every format (E412).
    """
    inner = {operand for node in graph.nodes for operand in node.operands}
    used = graph.used_results()
    finer = 2.0**-system.guard_bits  # words as outside may be as fine as those between operations

    def chosen(value: Value | None, magnitude: float, equation: str, *, outside: bool) -> BinaryPoint:
        resolved = 0.0 if value is None else _resolved(graph, value, found)
        try:
            if outside:
                return system.outside(max(magnitude, resolved * finer)).binary_point
            return system.inside(max(magnitude, resolved)).binary_point
        except OverflowError:
            raise _too_large(problem, source, equation, magnitude) from None

    specs: dict[Value | str, BinaryPoint] = {}
    for value, magnitude in found.values.items():
        node = graph.node(value)
        held = magnitude if value in used else 0.0  # an input that nothing uses needs no range
        specs[value] = chosen(value, held, node.origin, outside=node.op == "input" or value not in inner)
    for name, magnitude in found.outputs.items():
        value = graph.outputs[name]
        made = value if value in found.values else None
        specs[name] = chosen(made, magnitude, name, outside=True)
    return specs


def _too_large(problem: Problem, source: Source, equation: str, magnitude: float) -> Unattainable:
    size = f"of up to {magnitude:.3g}" if math.isfinite(magnitude) else "that may be beyond 1e+308"
    message = f"no fixed-point format holds a value {size}"
    hint = "choose other units, so that numbers are nearer to 1"
    return Unattainable([place(problem, source, equation, "E412", message, hint)])


def _resolved(graph: Graph, value: Value, found: Magnitudes) -> float:
    """Return the magnitude below which finer words between operations would only show the unit's own error.

    Angles err absolutely: by an eighth of 2^(3 - w), the ulp of w-bit words for +-4 rad, so words for
    +-1/2 rad keep them within one ulp.  Rotations err by a third of an ulp of words that hold the norm, or
    the larger result; the second result of an implicit equation by an ulp of the operands' words.
    """
    node = graph.node(value)

    def size(operand: Value) -> float:
        number = graph.constant(operand)
        return abs(nearest_double(number)) if number is not None else found.values.get(operand, 0.0)

    angle = value.result == node.definition.angle
    match node.op:
        case "vector" if angle and node.m != 0:
            return 0.5
        case "lightcone" | "implicit" if angle:
            return 0.5
        case "rotate" if node.m == 1:
            return math.hypot(*(size(operand) for operand in node.operands[:2])) / 2
        case "rotate" if node.m == -1:
            return max(found.values.get(Value(value.node, port), 0.0) for port in (0, 1))
        case "implicit":
            return max(size(operand) for operand in node.operands)
        case _:
            return 0.0


def _sign(column: np.ndarray) -> int:
    return int((column > 0).all()) - int((column < 0).all()) if column.size else 0


def _goals(
    graph: Graph, seen: Mapping[Value, np.ndarray], signs: Mapping[Value, int]
) -> dict[Value, Tightness]:
    """Return when enclosures are tight: of outputs to the bit, of others to two; divisors without 0."""
    leaving = set(graph.outputs.values())
    divisors = {n.operands[0] for n in graph.nodes if n.op == "vector" and n.m == 0}
    goals = {}
    for value, column in seen.items():
        reached = float(np.max(column, initial=0.0))
        octave = min(math.frexp(reached)[1] + (value not in leaving), _LAST_OCTAVE)
        most = math.ldexp(1.0, octave) if reached else 0.0
        divides = value in divisors
        least = float(np.min(column, initial=math.inf)) / 2 if divides else 0.0
        goals[value] = Tightness(most, signs[value] if divides else 0, least)
    return goals


def _unproven(
    problem: Problem,
    source: Source,
    graph: Graph,
    value: Value,
    samples: Mapping[str, np.ndarray],
    seen: np.ndarray,
    bound: float,
) -> tuple[float, Diagnostic | None]:
    """Return what the format of a value holds whose range is not known well, and a warning."""
    peak, at = _climbed(problem, graph, value, samples, seen)
    if bound <= peak * 2.0**_LOOSE_BITS < math.inf:
        return bound, None
    if not peak and bound < math.inf:
        return bound, None  # nothing but 0 was seen, which tells nothing
    node = graph.node(value)
    median = float(np.median(seen)) if seen.size else 0.0
    example = f"for example {peak:.3g} at {example_of(at, 0)}"
    if math.isinf(bound) and peak > _HOPELESS * median:
        message = f"no fixed-point format holds an intermediate value ({node.op}): it grows without bound"
        raise Unattainable([place(problem, source, node.origin, "E412", message, example)])
    held = min(bound, peak * _UNPROVEN_HEADROOM)
    message = (
        f"the range of an intermediate value ({node.op}) is not proven; its format holds up to {held:.3g}"
    )
    hint = f"samples beyond are marked invalid; the largest found is {example.removeprefix('for example ')}"
    return held, place(problem, source, node.origin, "W412", message, hint, Severity.WARNING)


def _climbed(
    problem: Problem, graph: Graph, value: Value, samples: Mapping[str, np.ndarray], seen: np.ndarray
) -> tuple[float, dict[str, np.ndarray]]:
    """Return the largest magnitude of a value that a random local search finds, and the input.

    The search goes by double precision; what it finds is evaluated in high precision.  Where the problem has
    samples, they are the workspace and all that is looked at.
    """
    part = Graph(graph.nodes[: value.node + 1], {"value": value})

    def height(columns: Mapping[str, np.ndarray]) -> np.ndarray:
        size = np.abs(all_results(part, columns)[value.node][value.result])
        return np.where(np.isfinite(size), size, -1.0)

    search = climbing(
        input_intervals(problem),
        samples,
        climbers=_CLIMBERS,
        rounds=_CLIMBS if problem.samples is None else 0,
        towards_poles=True,
    )
    points, _ = climb(search, height)
    peak, at = _peak(part, points)
    # Where rounding has led the search astray, a sample is higher.
    return (peak, at) if peak >= np.max(seen, initial=0.0) else _peak(part, samples)


def _peak(part: Graph, points: Mapping[str, np.ndarray]) -> tuple[float, dict[str, np.ndarray]]:
    """Return the largest magnitude of the output of a graph among points, and where it is."""
    numbers, _ = reference_outputs(part, points)
    sizes = np.nan_to_num(np.abs(numbers["value"]), nan=0.0)
    top = int(np.argmax(sizes))
    return float(sizes[top]), {name: column[top : top + 1] for name, column in points.items()}
