"""Evaluation of a graph in balls (Arb): midpoints with proven error radii, for most samples the fastest way.

Every number that a decision or a function with a limited domain takes has `_GOOD_BITS` certain bits, so
that its sign is known, or is exactly zero.  Sums and products take balls of any width.
An operation that is certainly outside its domain has no value, nor has what follows from it.  Whatever the
balls leave open (a result that may be outside its domain, a comparison of equals, a number that no double
holds, a result between two doubles) ends the sample as undecided: the caller evaluates it by
`cordicc.ir.meaning.reference`, whose rounded numbers decide such cases.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb, ctx

from cordicc.ir.graph import Graph, Node

_PRECISION = 128
_GOOD_BITS = 64
_LARGEST, _SMALLEST = 1e300, 1e-300
_BELOW_PI = 3.14
_TRIALS = 64
"""Samples after which balls are given up if they decide less than half."""

_KEPT = 64
"""Nodes for which it is known what to go on with after them."""

Ball = Any  # flint.arb
_Step = tuple[Callable[..., Ball], list[int], int, bool, Node]
"""Function, nodes of the operands, node, whether the result is to be looked at, the node itself."""

_ONE, _ZERO = arb(1), arb(0)
_NO_VALUE = arb("nan")


class _Undecided(Exception):
    """A sample whose results the balls do not settle."""


def ball_outputs(graph: Graph, inputs: Mapping[str, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Evaluate the outputs of a graph on samples.

    Args:
        graph: any graph; one with operations that balls do not do leaves every sample undecided.
        inputs: for each input of the graph a float64 array of shape (count,), taken as exact numbers.
        count: of samples.

    Returns:
        The outputs, float64 of shape (outputs, count), the exact values correctly rounded, and which of the
        samples are decided, bool of shape (count,).  An output of a decided sample that is NaN has no value.
    """
    results = np.full((len(graph.outputs), count), np.nan)
    decided = np.zeros(count, dtype=bool)
    if any(node.op not in OPERATIONS for node in graph.nodes if node.op not in ("input", "const")):
        return results, decided
    with ctx.workprec(_PRECISION):
        run = _Program(graph, inputs).run
        undecided = 0
        finite = np.logical_and.reduce([np.isfinite(column) for column in inputs.values()], initial=True)
        for tried, sample in enumerate(np.flatnonzero(np.broadcast_to(finite, count)).tolist()):
            try:
                results[:, sample] = run(sample)
                decided[sample] = True
            except _Undecided:
                undecided += 1
                if tried >= _TRIALS and 2 * undecided > tried:
                    break
    return results, decided


class _Program:
    """The operations of a graph on one sample after the other."""

    def __init__(self, graph: Graph, inputs: Mapping[str, np.ndarray]) -> None:
        self._values: list[Ball] = [None] * len(graph.nodes)
        self._columns: list[tuple[int, list[float]]] = []
        self._wanted = [value.node for value in graph.outputs.values()]
        steps: list[_Step] = []
        checked = _checked(graph, inputs)
        for index, node in enumerate(graph.nodes):
            if node.op == "input":
                self._columns.append((index, inputs[node.name].tolist()))
            elif node.op == "const":
                self._values[index] = _rational(node.number)
            else:
                function, operands = OPERATIONS[node.op](**node.named), [v.node for v in node.operands]
                steps.append((function, operands, index, index in checked, node))
        self._steps = steps
        self._left: dict[int, tuple[list[_Step], set[int]]] = {}

    def run(self, sample: int) -> list[float]:
        """Return the outputs for a sample, NaN for those without a value.  Raises _Undecided."""
        values, value_of = self._values, self._values.__getitem__
        for at, numbers in self._columns:
            values[at] = arb(numbers[sample])
        for step in self._steps:
            function, operands, at, check, _ = step
            made = function(*map(value_of, operands))
            # The midpoint of what is not finite, or of what has no value, is none of these either.
            if check and (made.rel_accuracy_bits() < _GOOD_BITS or not -_LARGEST < float(made) < _LARGEST):
                self._be_outside(step)
                return self._without(at)
            values[at] = made
        return [_rounded(values[at]) for at in self._wanted]

    def _without(self, node: int) -> list[float]:
        """Go on after a node without a value, leaving out what hangs on such nodes."""
        values = self._values
        missing: set[int] = set()
        steps, gone = self._after(node)
        for step in steps:
            function, operands, at, check, _ = step
            if missing and not missing.isdisjoint(operands):
                missing.add(at)
                continue
            made = function(*(values[operand] for operand in operands))
            if check and (made.rel_accuracy_bits() < _GOOD_BITS or not -_LARGEST < float(made) < _LARGEST):
                self._be_outside(step)
                missing.add(at)
            values[at] = made
        return [math.nan if at in gone or at in missing else _rounded(values[at]) for at in self._wanted]

    def _be_outside(self, step: _Step) -> None:
        """Raise _Undecided unless the operands of a step are certainly outside its domain."""
        _, operands, _, _, node = step
        test = _OUTSIDE.get(node.op)
        if test is None or not test(**node.named)(*(self._values[operand] for operand in operands)):
            raise _Undecided

    def _after(self, node: int) -> tuple[list[_Step], set[int]]:
        """Return the steps after a node that outputs need which do not hang on it, and what hangs on it."""
        if node not in self._left:
            if len(self._left) == _KEPT:
                self._left.clear()
            gone = {node}
            for _, operands, at, _, _ in self._steps:
                if not gone.isdisjoint(operands):
                    gone.add(at)
            needed = {at for at in self._wanted if at not in gone}
            steps = []
            for step in reversed(self._steps):
                if step[2] in needed:
                    needed.update(step[1])
                    if step[2] > node:
                        steps.append(step)
            self._left[node] = steps[::-1], gone
        return self._left[node]


def _checked(graph: Graph, inputs: Mapping[str, np.ndarray]) -> set[int]:
    """Return the nodes whose numbers must be looked at: uncertain or large ones do not go on from there.

    Not those that the operations in `_SIZES` alone take and that are never large.
    """
    sizes: list[float] = []
    checked = set()
    for index, node in enumerate(graph.nodes):
        if node.op == "input":
            size = float(np.max(np.abs(inputs[node.name]), initial=0.0))
        elif node.op == "const":
            size = _size(node.number)
        else:
            bound = _SIZES.get(node.op)
            size = _LARGEST if bound is None else bound(node, *(sizes[v.node] for v in node.operands))
        # No less than 1, so that products of bounds do not vanish.
        sizes.append(max(size, 1.0))
        if not size < _LARGEST:
            checked.add(index)
        if node.op not in _SIZES:
            checked.update(v.node for v in node.operands)
    return checked


def _size(number: Fraction) -> float:
    return float(abs(number)) if abs(number) < _LARGEST else _LARGEST


_SIZES: dict[str, Callable[..., float]] = {
    "add": lambda node, a, b: a + b,
    "sub": lambda node, a, b: a + b,
    "mul": lambda node, a, b: a * b,
    "cmul": lambda node, a: a * _size(node.factor),
    "neg": lambda node, a: a,
    "sin": lambda node, a: 1.0,
    "cos": lambda node, a: 1.0,
}
"""How large results can be, for the operations that take balls of any width."""


def _rounded(ball: Ball) -> float:
    """Return the double next to every number of the ball."""
    number = float(ball.lower())
    if number != float(ball.upper()) or not (_SMALLEST < abs(number) < _LARGEST or ball.is_zero()):
        raise _Undecided
    return number


def _rational(number: Fraction | str | int) -> Ball:
    exact = Fraction(number)
    return arb(exact.numerator) / arb(exact.denominator)


def _plain(function: Callable[..., Ball]) -> Callable[[], Callable[..., Ball]]:
    """Make a table row of an operation without parameters."""
    return lambda: function


def _less(a: Ball, b: Ball) -> bool:
    """Tell whether a < b; undecided where both are possible."""
    if a < b:
        return True
    if a >= b:
        return False
    raise _Undecided


def _negative(a: Ball) -> bool:
    """Tell the sign of a number that goes on, which is certain."""
    return bool(a < 0)


def _defined(holds: bool) -> None:
    if not holds:
        raise _Undecided


def _sign(a: Ball) -> Ball:
    return arb((a > 0) - (a < 0))


def _wrap(a: Ball) -> Ball:
    if -_BELOW_PI < float(a) < _BELOW_PI:
        return a
    half, turn = arb.pi(), 2 * arb.pi()
    turns = round(float(a / turn))
    rest = a - turns * turn if turns else a
    _defined(bool(-half < rest) and bool(rest < half))
    return rest


def _atan2(y: Ball, x: Ball) -> Ball:
    return _NO_VALUE if x.is_zero() and y.is_zero() else arb.atan2(y, x)


def _hypot(a: Ball, b: Ball) -> Ball:
    return (a * a + b * b).sqrt()


def _power(exponent: Fraction) -> Callable[[Ball], Ball]:
    half = Fraction(exponent)
    if half.denominator == 1:
        if half == 2:
            return lambda a: a * a
        whole = arb(half.numerator)
        return lambda a: a**whole
    twice = arb(half.numerator)
    return lambda a: a.sqrt() ** twice


def _scaled(factor: Fraction) -> Callable[[Ball], Ball]:
    number = _rational(factor)
    return lambda a: a * number


def _shifted(exponent: Fraction) -> Callable[[Ball], Ball]:
    number = arb(2) ** int(exponent)
    return lambda a: a * number


_HOLDS: dict[str, Callable[[Ball], bool]] = {
    "any": lambda s: True,
    "nonzero": lambda s: not s.is_zero(),
    "nonnegative": lambda s: not _negative(s),
    "positive": lambda s: bool(s > 0),
}


def _guard(condition: str) -> Callable[[Ball, Ball], Ball]:
    holds = _HOLDS[condition]
    return lambda a, s: a if holds(s) else _NO_VALUE


def _solve(m: int, branch: str) -> Callable[[Ball, Ball, Ball], Ball]:
    if m == 1:
        sign = 1 if branch == "+" else -1
        return lambda A, B, C: _atan2(A, B) + sign * (C / _hypot(A, B)).acos()
    return lambda A, B, C: _hyperbolic(branch, A, B, C)


def _hyperbolic(branch: str, A: Ball, B: Ball, C: Ball) -> Ball:
    """Return the logarithm of the root E > 0 of p E^2 - C E + q = 0; see `cordicc.ir.meaning.reference`."""
    p, q = (B + A) / 2, (B - A) / 2
    root = (C * C - 4 * p * q).sqrt()
    if C < 0:
        p, q = -p, -q
    total = abs(C) + root
    p_positive, q_positive = _less(_ZERO, p), _less(_ZERO, q)
    _defined(not (p_positive and q_positive and branch == "none"))
    if p_positive and not (q_positive and branch == "-"):
        return (total / (2 * p)).log()
    _defined(q_positive)
    return (2 * q / total).log()


def _solve_pair(A1: Ball, B1: Ball, C1: Ball, A2: Ball, B2: Ball, C2: Ball) -> Ball:
    determinant = B1 * A2 - B2 * A1
    cosine, sine = (C1 * A2 - C2 * A1) / determinant, (B1 * C2 - B2 * C1) / determinant
    return _atan2(sine, cosine)


OPERATIONS: dict[str, Callable[..., Callable[..., Ball]]] = {
    "add": _plain(operator.add),
    "sub": _plain(operator.sub),
    "mul": _plain(operator.mul),
    "cmul": _scaled,
    "shift": _shifted,
    "neg": _plain(operator.neg),
    "abs": _plain(abs),
    "sign": _plain(_sign),
    "min": _plain(lambda a, b: a if _less(a, b) else b),
    "max": _plain(lambda a, b: b if _less(a, b) else a),
    "flip": _plain(lambda a, s: -a if _negative(s) else a),
    "select": _plain(lambda s, a, b: b if _negative(s) else a),
    "guard": _guard,
    "wrap": _plain(_wrap),
    "div": _plain(operator.truediv),
    "pow": _power,
    "sqrt": _plain(arb.sqrt),
    "hypot": _plain(_hypot),
    "sin": _plain(arb.sin),
    "cos": _plain(arb.cos),
    "tan": _plain(arb.tan),
    "asin": _plain(arb.asin),
    "acos": _plain(arb.acos),
    "atan": _plain(arb.atan),
    "atan2": _plain(_atan2),
    "sinh": _plain(arb.sinh),
    "cosh": _plain(arb.cosh),
    "tanh": _plain(arb.tanh),
    "asinh": _plain(arb.asinh),
    "acosh": _plain(arb.acosh),
    "atanh": _plain(arb.atanh),
    "exp": _plain(arb.exp),
    "log": _plain(arb.log),
    "solve": _solve,
    "solve_pair": _plain(_solve_pair),
}


def _outside_power(exponent: Fraction) -> Callable[[Ball], bool]:
    half = Fraction(exponent)
    if half.denominator == 1:
        return lambda a: half < 0 and bool(a.is_zero())
    return lambda a: bool(a < 0) or (half < 0 and bool(a.is_zero()))


def _outside_solve(m: int, branch: str) -> Callable[[Ball, Ball, Ball], bool]:
    if m == 1:
        return lambda A, B, C: bool(A * A + B * B < C * C)
    return lambda A, B, C: bool(C * C < B * B - A * A)


_OUTSIDE: dict[str, Callable[..., Callable[..., bool]]] = {
    "sqrt": lambda: lambda a: bool(a < 0),
    "log": lambda: lambda a: bool(a <= 0),
    "div": lambda: lambda a, b: bool(b.is_zero()),
    "atan2": lambda: lambda y, x: bool(x.is_zero() and y.is_zero()),
    "asin": lambda: lambda a: bool(abs(a) > _ONE),
    "acos": lambda: lambda a: bool(abs(a) > _ONE),
    "acosh": lambda: lambda a: bool(a < _ONE),
    "atanh": lambda: lambda a: bool(abs(a) >= _ONE),
    "pow": _outside_power,
    "guard": lambda condition: lambda a, s: not _HOLDS[condition](s),  # the sign of s is certain
    "solve": _outside_solve,
}
"""Whether operands are certainly outside the domain of an operation that has no usable result."""
