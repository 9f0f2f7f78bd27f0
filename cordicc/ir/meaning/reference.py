"""High-precision evaluation of a graph: the yardstick for every simulation and every rewrite.

Each operation is evaluated as it is defined in `cordicc.ir.ops`, sample by sample: in balls with proven
radii (`cordicc.ir.meaning.balls`) where these settle every result, else by mpmath's floating point at
`PRECISION` bits.  A result without a value is None; so is all that follows from it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from itertools import cycle

import numpy as np
from mpmath import libmp
from mpmath.libmp import fone

from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning import balls
from cordicc.ir.meaning.rounded_operations import OPERATIONS, WORKING, Result, from_fraction

_LARGEST_EXPONENT = 16384
"""Numbers of 2^16384, beyond which quadruple precision overflows, count as having no value."""

_LARGEST_DOUBLE = sys.float_info.max


def reference_outputs(
    graph: Graph, inputs: Mapping[str, np.ndarray], *, jitter: bool = False
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Evaluate the outputs of a graph on samples.

    Args:
        graph: any graph.
        inputs: for each input of the graph a float64 array of shape (n,), taken as exact numbers.
        jitter: multiply every operand, at each use, by a factor within 2^-90 of 1, from a fixed
            sequence of random ones, to see what hangs on rounding.

    Returns:
        The outputs, float64 of shape (n,), correctly rounded from at least `PRECISION` bits, NaN where
        they have no value, and the largest double for numbers beyond it; and which samples are valid:
        every operation of the graph has its value.
    """
    count = len(next(iter(inputs.values()))) if inputs else 1
    results, settled = np.full((len(graph.outputs), count), np.nan), np.zeros(count, dtype=bool)
    if not jitter:
        results, settled = balls.ball_outputs(graph, inputs, count)
    if not settled.all():
        rest = np.flatnonzero(~settled)
        results[:, rest] = rounded_outputs(graph, inputs, rest.tolist(), jitter=jitter)
    return dict(zip(graph.outputs, results, strict=True)), ~np.isnan(results).any(axis=0)


def rounded_outputs(
    graph: Graph, inputs: Mapping[str, np.ndarray], samples: list[int], *, jitter: bool = False
) -> np.ndarray:
    """Return the outputs on some samples rounded to `PRECISION` bits, of shape (outputs, samples)."""
    results = np.full((len(graph.outputs), len(samples)), np.nan)
    slot = _slots(graph)
    values: list[Result] = [None] * len(slot)
    columns: list[tuple[int, list[float]]] = []
    program = []
    for index, node in enumerate(graph.nodes):
        first = slot[Value(index)]
        if node.op == "input":
            columns.append((first, inputs[node.name].tolist()))
        elif node.op == "const":
            values[first] = from_fraction(node.number)
        else:
            many = len(node.definition.results) > 1
            program.append((OPERATIONS[node.op](**node.named), [slot[v] for v in node.operands], first, many))
    shake = _shaker() if jitter else None
    wanted = [(row, slot[value]) for row, value in enumerate(graph.outputs.values())]
    for column, sample in enumerate(samples):
        for at, numbers in columns:
            values[at] = libmp.from_float(numbers[sample])
        for function, operands, at, many in program:
            arguments = [values[operand] for operand in operands]
            if shake is not None:
                arguments = [shake(argument) for argument in arguments]
            made = None if None in arguments else function(*arguments)
            if made is not None:
                made = tuple(map(_bounded, made)) if many else _bounded(made)
            if many:
                values[at], values[at + 1] = made or (None, None)
            else:
                values[at] = made
        for row, at in wanted:
            result = values[at]
            if result is not None:
                number = libmp.to_float(result, rnd="n")
                results[row, column] = max(-_LARGEST_DOUBLE, min(_LARGEST_DOUBLE, number))
    return results


def _bounded(result: Result) -> Result:
    """Return None for a number that no format holds, so that towers of exponentials end."""
    return None if result is not None and result[2] + result[3] > _LARGEST_EXPONENT else result


def _shaker() -> Callable[[Result], Result]:
    """Return a function that changes numbers by relative amounts up to 2^-90."""
    numbers = np.random.Generator(np.random.PCG64(0)).uniform(-(2.0**-90), 2.0**-90, 997)
    factors = cycle([libmp.mpf_add(fone, libmp.from_float(x), *WORKING) for x in numbers.tolist()])
    return lambda result: None if result is None else libmp.mpf_mul(result, next(factors), *WORKING)


def _slots(graph: Graph) -> dict[Value, int]:
    """Return a number for each result of each node, those of one node side by side."""
    slots: dict[Value, int] = {}
    for index, node in enumerate(graph.nodes):
        for result in range(len(node.definition.results)):
            slots[Value(index, result)] = len(slots)
    return slots
