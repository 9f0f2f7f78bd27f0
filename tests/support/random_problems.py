"""Random problems over the whole language, and what they mean, evaluated without cordicc.

A problem is written as text and as expressions of Python, which mpmath evaluates here.  Its ranges cross
the borders of its domain more often than not, and some expressions are identities in disguise, as those
are what rewriting feeds on.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mpmath import fp, mp

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.emulate.ports import PortFormats
from cordicc.plan.model import Plan

DIGITS = 34

_RANGES = (
    (-1.0, 1.0), (0.1, 0.9), (-2.0, 3.0), (0.25, 0.75), (-0.5, 0.5), (0.0, 2.0), (-4.0, -1.0), (-1.0, 0.0),
)  # fmt: skip
_NUMBERS = ("2", "0.5", "0.1", "3", "0.7", "1", "pi", "0.35")
_UNARY = (
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
    "log", "sqrt", "sqrt", "abs", "sign",
)  # fmt: skip
_BINARY = ("hypot", "atan2", "min", "max")
_POWERS = ("2", "3", "0.5", "-1", "1.5", "-0.5")
_DISGUISED = (
    "sqrt({a})*sqrt({a})",
    "sqrt({a})**2",
    "cos(acos({a}))",
    "sin(acos({a}))",
    "cos(2*acos({a}))",
    "exp(log({a}))",
    "tan(atan2({a}, {b}))",
    "({a})/({b})*({b})",
    "cosh(acosh({a}))",
    "sqrt(({a})**2)",
    "sqrt(1 - ({a})**2)",
    "atan2(sqrt(1 - ({a})**2), {a})",
    "cos(acos(hypot({a}, 0.7)))",
    "hypot({a}, {b})*cos(atan2({b}, {a}))",
    "({a})*(({b}) - ({b}))",
    "cos({a})**2 + sin({a})**2",
    "sqrt(({a})**2 - ({b})**2)",
    "atan2({a}, {b}) + acos(({a})/hypot({a}, {b}))",
    "log(({a})**2)",
    "min({a}, 0)*sqrt({b})",
    "sqrt(({a})*({b}))*sqrt({b})",
)
_CONDITIONS = ("{t} > 0", "{t} < 0", "cos({t}) > 0", "sin({t}) < 0")


_LARGEST_ERROR = 2.0**-6
"""Beyond, evaluations with such errors have hardly a value anywhere."""


class NoValue(Exception):
    """An expression leaves its domain."""


@dataclass
class Noise:
    """What rounding an evaluation suffers: relative and absolute sizes, from a seeded generator.

    Without any an evaluation has `DIGITS` digits, else it is in doubles.  `tolerance` is what may be beyond a
    border and counts as on it, and what no quotient is taken by.
    """

    relative: float = 0.0
    absolute: float = 0.0
    generator: random.Random = field(default_factory=lambda: random.Random(0))
    tolerance: float = 0.0

    @property
    def context(self) -> Any:
        """The numbers that are used."""
        return fp if self.relative or self.absolute else mp

    @property
    def library(self) -> Any:
        """The functions that are used, where it has them."""
        return math if self.context is fp else mp

    def of(self, value: Any) -> Any:
        """Return a number that may be off by that much."""
        if isinstance(value, (complex, mp.mpc)) or not mp.isfinite(value):
            raise NoValue
        if self.relative or self.absolute:
            value += value * self.relative * self.generator.uniform(-1, 1)
            value += self.absolute * self.generator.uniform(-1, 1)
        return value


class Real:
    """A number of mpmath with Python's operators and rounding noise."""

    noise = Noise()

    def __init__(self, value: Any) -> None:
        self.value = Real.noise.context.mpf(value)

    def _made(self, value: Any) -> Real:
        return Real(Real.noise.of(value))

    def __add__(self, other: Any) -> Real:
        return self._made(self.value + _number(other))

    def __radd__(self, other: Any) -> Real:
        return self._made(_number(other) + self.value)

    def __sub__(self, other: Any) -> Real:
        return self._made(self.value - _number(other))

    def __rsub__(self, other: Any) -> Real:
        return self._made(_number(other) - self.value)

    def __mul__(self, other: Any) -> Real:
        return self._made(self.value * _number(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Real:
        return self._made(_quotient(self.value, _number(other)))

    def __rtruediv__(self, other: Any) -> Real:
        return self._made(_quotient(_number(other), self.value))

    def __neg__(self) -> Real:
        return Real(-self.value)

    def __pow__(self, exponent: Any) -> Real:
        power = _number(exponent)
        if (abs(self.value) <= Real.noise.tolerance and power < 0) or (
            self.value < 0 and power != int(power)
        ):
            raise NoValue
        return self._made(self.value**power)


def _number(value: Any) -> Any:
    return value.value if isinstance(value, Real) else Real.noise.context.mpf(value)


def _quotient(a: Any, b: Any) -> Any:
    if abs(b) <= Real.noise.tolerance:
        raise NoValue
    return a / b


def _at_least(end: int) -> Any:
    return lambda x, tolerance: end if end - tolerance <= x < end else x


def _at_most_one(x: Any, tolerance: float) -> Any:
    return mp.sign(x) if 1 < abs(x) <= 1 + tolerance else x


_BORDERS = {"sqrt": _at_least(0), "acosh": _at_least(1), "acos": _at_most_one, "asin": _at_most_one}
"""What to take for an operand beside the border of a domain."""

_INSIDE: dict[str, Any] = {
    "sqrt": lambda x, depth: depth,
    "acosh": lambda x, depth: 1 + depth,
    "acos": lambda x, depth: math.copysign(1 - depth, x),
    "asin": lambda x, depth: math.copysign(1 - depth, x),
}
"""Operands within the border of a domain, by so much."""

_POLES: dict[str, Any] = {
    "tan": lambda x: abs(mp.cos(x)),
    "log": lambda x: x,
    "atanh": lambda x: 1 - abs(x),
    "atan2": lambda y, x: max(abs(y), abs(x)),
}
"""How far operands are from what the function has no value at."""


def _function(name: str) -> Any:
    def apply(*operands: Any) -> Real:
        a = [_number(each) for each in operands]
        tolerance = Real.noise.tolerance
        if tolerance and name in _BORDERS:
            a = [_BORDERS[name](a[0], tolerance)]
        error = Real.noise.absolute
        near = error and name in _BORDERS and _BORDERS[name](a[0], error) != a[0]
        if near and Real.noise.generator.random() < 0.5:
            # Beyond a border by less than rounding: a unit may take it for any number on the other side.
            a = [_INSIDE[name](a[0], Real.noise.generator.uniform(0, error))]
        if tolerance and name in _POLES and _POLES[name](*a) <= tolerance:
            raise NoValue
        outside: Any = {
            "sqrt": lambda x: x < 0,
            "acos": lambda x: abs(x) > 1,
            "asin": lambda x: abs(x) > 1,
            "acosh": lambda x: x < 1,
            "atanh": lambda x: abs(x) >= 1,
            "log": lambda x: x <= 0,
            "atan2": lambda y, x: x == 0 and y == 0,
        }.get(name)
        if outside is not None and outside(*a):
            raise NoValue
        if name in ("exp", "cosh", "sinh") and abs(a[0]) > 700:
            raise NoValue
        made: Any = {"abs": abs, "min": min, "max": max}.get(name) or getattr(Real.noise.library, name, None)
        made = made or getattr(mp, name)
        return Real(Real.noise.of(made(*a)))

    return apply


FUNCTIONS: dict[str, Any] = {name: _function(name) for name in {*_UNARY, *_BINARY}}


def _evaluated(text: str, names: Mapping[str, Any]) -> Real:
    made = eval(text, {"__builtins__": {}}, {**FUNCTIONS, "pi": Real(+Real.noise.context.pi), **names})
    return made if isinstance(made, Real) else Real(made)


def circular(A: Real, B: Real, C: Real, sign: int) -> Real:
    """Return atan2(A, B) +- acos(C/sqrt(A^2 + B^2)).

    A vector that is no longer than the absolute noise may point anywhere and reach any C, also where A and B
    are one value: a unit does not know that they err alike.
    """
    f, noise = FUNCTIONS, Real.noise
    if noise.absolute and max(abs(A.value), abs(B.value)) <= noise.absolute:
        return Real(noise.generator.uniform(-math.pi, math.pi))
    angle: Real = f["atan2"](A, B) + sign * f["acos"](C / f["hypot"](A, B))
    return angle


def _pair(one: Sequence[Real], two: Sequence[Real]) -> Real:
    """Return the angle of the solution of two equations B c + A s = C, given as (B, A, C)."""
    determinant = one[0] * two[1] - two[0] * one[1]
    cosine = (one[2] * two[1] - two[2] * one[1]) / determinant
    sine = (one[0] * two[2] - two[0] * one[2]) / determinant
    angle: Real = FUNCTIONS["atan2"](sine, cosine)
    return angle


@dataclass(frozen=True)
class Step:
    """An equation: the name it defines, and how: an expression, or the coefficients of a solve."""

    name: str
    kind: str
    parts: tuple[str, ...]

    @property
    def text(self) -> str:
        """Return the item of the problem file."""
        p, t = self.parts, self.name
        if self.kind == "plain":
            return f"  - {t} = {p[0]}\n"
        if self.kind == "pair":
            one, two = (f"({b})*cos({t}) + ({a})*sin({t}) = {c}" for b, a, c in (p[:3], p[3:]))
            return f"  - solve: ['{one}', '{two}']\n    for: {t}\n"
        branch = f'"{p[3]}"' if self.kind == "solve" else p[3].format(t=t)
        return (
            f"  - solve: ({p[0]})*cos({t}) + ({p[1]})*sin({t}) = {p[2]}\n    for: {t}\n    branch: {branch}\n"
        )

    def value(self, names: Mapping[str, Any]) -> Real:
        """Return the value; raises NoValue."""
        if self.kind == "plain":
            return _evaluated(self.parts[0], names)
        count = 6 if self.kind == "pair" else 3
        numbers = [_evaluated(each, names) for each in self.parts[:count]]
        if self.kind == "pair":
            return _pair(numbers[:3], numbers[3:])
        B, A, C = numbers
        if self.kind == "solve":
            return circular(A, B, C, 1 if self.parts[3] == "+" else -1)
        for sign in (1, -1):
            angle = circular(A, B, C, sign)
            inside = mp.pi - (mp.pi - angle.value) % (2 * mp.pi)
            shown = self.parts[3].format(t="t")
            left, relation, _ = shown.split()
            excess = _evaluated(left, {"t": Real(inside)}).value
            allowed = Real.noise.tolerance
            if Real.noise.absolute:
                allowed = Real.noise.generator.choice((0.0, Real.noise.absolute))
            if (excess if relation == ">" else -excess) >= -allowed:
                return angle
        raise NoValue


@dataclass(frozen=True)
class RandomProblem:
    """A problem: ranges of the inputs, equations in order, and the names that are outputs."""

    seed: int
    ranges: Mapping[str, tuple[float, float]]
    steps: tuple[Step, ...]
    outputs: tuple[str, ...]

    @property
    def text(self) -> str:
        """Return the problem file."""
        inputs = "".join(f"  {name}: [{lo}, {hi}]\n" for name, (lo, hi) in self.ranges.items())
        outputs = ", ".join(f"{name}: {{wrap: false}}" for name in self.outputs)
        steps = "".join(step.text for step in self.steps)
        return f"name: random-{self.seed}\ninputs:\n{inputs}equations:\n{steps}outputs: {{{outputs}}}\n"

    def evaluate(self, sample: Mapping[str, float], noise: Noise | None = None) -> dict[str, float] | None:
        """Return the outputs at a sample, not wrapped; None where an output has no value.

        A step that no output needs, on any way, does not count.
        """
        Real.noise = noise or Noise()
        names: dict[str, Any] = {name: Real(value) for name, value in sample.items()}
        needed = self._needed()
        try:
            with mp.workdps(DIGITS):
                for step in self.steps:
                    if step.name in needed:
                        names[step.name] = step.value(names)
        except (NoValue, ZeroDivisionError, OverflowError):
            return None
        return {name: float(names[name].value) for name in self.outputs}

    def _needed(self) -> set[str]:
        needed = set(self.outputs)
        for step in reversed(self.steps):
            if step.name in needed:
                needed |= {other.name for other in self.steps if any(other.name in p for p in step.parts)}
        return needed

    def valid(self, samples: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return which samples have values; `samples` holds an array of shape (n,) by input."""
        count = len(next(iter(samples.values())))
        rows = ({name: float(column[i]) for name, column in samples.items()} for i in range(count))
        return np.array([self.evaluate(row) is not None for row in rows])


def clear_validity(
    problem: RandomProblem, samples: Mapping[str, np.ndarray], erring: float, tries: int = 10
) -> tuple[np.ndarray, np.ndarray]:
    """Return which samples have a value, and which do or do not so clearly.

    A sample is clear if the answer stays when every operation errs by a relative and in every other try
    also by an absolute amount up to `erring`, and inputs are moved by as much of their ranges.  One that
    is on a border or at a pole but for the last of `DIGITS` digits is not: on either side there may be none.
    Nor is any where words are so coarse that such errors tell nothing.
    """
    generator = random.Random(5)
    valid = problem.valid(samples)
    clear = np.ones(valid.size, dtype=bool)
    for index in range(valid.size):
        here = {name: float(column[index]) for name, column in samples.items()}
        tolerant = problem.evaluate(here, Noise(tolerance=1e-25))
        clear[index] = erring <= _LARGEST_ERROR and valid[index] == (tolerant is not None)
        for attempt in range(tries):
            moved = {
                name: at
                + erring * (problem.ranges[name][1] - problem.ranges[name][0]) * generator.uniform(-1, 1)
                for name, at in here.items()
            }
            noise = Noise(erring, erring if attempt % 2 else 0.0, generator)
            if (problem.evaluate(moved, noise) is not None) != valid[index]:
                clear[index] = False
                break
    return valid, clear


def is_clear(problem: RandomProblem, samples: Mapping[str, np.ndarray], index: int, erring: float) -> bool:
    """Tell whether a sample whose answer ten tries left as it is keeps it in many more.

    Of samples at a border, where every other try changes the answer, one in a thousand seems clear in ten.
    """
    one = {name: column[index : index + 1] for name, column in samples.items()}
    return bool(clear_validity(problem, one, erring, tries=200)[1][0])


def spread(problem: RandomProblem, sample: dict[str, float], erring: float) -> dict[str, float] | None:
    """Return by output how far rounding moves it at a sample, None where that has no value in some try."""
    made: list[dict[str, float]] = []
    for attempt in range(8):
        noise = Noise(erring, erring if attempt % 2 else 0.0)
        noise.generator.seed(attempt)
        values = problem.evaluate(sample, noise)
        if values is None:
            return None
        made.append(values)
    return {name: float(np.ptp([each[name] for each in made])) for name in problem.outputs}


def resolution(plan: Plan) -> float:
    """Return the step of the coarsest fixed-point format of a plan, 0 if it has none."""
    formats = PortFormats.of(plan, plan.arithmetic)
    every = (*formats.values.values(), *formats.outputs.values())
    return max((2.0**-f.fraction_bits for f in every if isinstance(f, FixedPoint)), default=0.0)


class _Writer:
    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def leaf(self, names: Sequence[str]) -> str:
        pick = self.random
        return pick.choice(names) if pick.random() < 0.8 else pick.choice(_NUMBERS)

    def expression(self, names: Sequence[str], depth: int) -> str:
        pick = self.random
        kind = pick.random()
        if depth == 0:
            return self.leaf(names)
        a = self.expression(names, depth - 1)
        if kind < 0.28:
            return f"{pick.choice(_UNARY)}({a})"
        b = self.expression(names, pick.randrange(depth))
        if kind < 0.36:
            return f"{pick.choice(_BINARY)}({a}, {b})"
        if kind < 0.42:
            return f"({a})**{pick.choice(_POWERS)}"
        if kind < 0.60:
            return pick.choice(_DISGUISED).format(a=a, b=b)
        return f"({a} {pick.choice('+-*/*+')} ({b}))"

    def step(self, number: int, names: Sequence[str]) -> Step:
        pick, name = self.random, f"w{number}"

        def small() -> str:
            return self.expression(names, pick.randrange(2))

        kind = pick.random()
        if kind < 0.62:
            return Step(name, "plain", (self.expression(names, 1 + pick.randrange(3)),))
        if kind < 0.80:
            return Step(name, "solve", (small(), small(), small(), pick.choice("+-")))
        if kind < 0.90:
            return Step(name, "condition", (small(), small(), small(), pick.choice(_CONDITIONS)))
        return Step(name, "pair", tuple(small() for _ in range(6)))


def random_problem(seed: int) -> RandomProblem:
    """Return the problem of a seed."""
    writer = _Writer(seed)
    pick = writer.random
    inputs = ("x", "y", "z")[: 1 + pick.randrange(3)]
    ranges = {name: pick.choice(_RANGES) for name in inputs}
    steps: list[Step] = []
    for number in range(1 + pick.randrange(4)):
        steps.append(writer.step(number, [*inputs, *(step.name for step in steps)]))
    used = {step.name for step in steps if pick.random() < 0.4} | {steps[-1].name}
    return RandomProblem(seed, ranges, tuple(steps), tuple(s.name for s in steps if s.name in used))


def draw(problem: RandomProblem, count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Return samples, uniform in the ranges."""
    generator = np.random.Generator(np.random.PCG64(seed))
    return {name: generator.uniform(lo, hi, count) for name, (lo, hi) in problem.ranges.items()}


def beside_borders(problem: RandomProblem, count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Return samples on both sides of borders of the domain, at several distances; perhaps none.

    Borders are found on segments between samples with a value and without one, by halving.
    """
    samples = draw(problem, 2 * count, seed)
    valid = problem.valid(samples)
    inner, outer = np.flatnonzero(valid), np.flatnonzero(~valid)
    names = list(samples)
    rows = np.stack([samples[name] for name in names], axis=1)
    found = []
    for i, o in list(zip(inner, outer, strict=False))[:count]:
        inside, beyond = rows[i], rows[o]
        for _ in range(40):
            middle = (inside + beyond) / 2
            if problem.evaluate(dict(zip(names, middle.tolist(), strict=True))) is None:
                beyond = middle
            else:
                inside = middle
        direction = rows[o] - rows[i]
        for distance in (0.05, 1e-2, 1e-3, 1e-4):
            found += [inside - distance * direction, inside + distance * direction]
    made = np.array(found).reshape(-1, len(names))
    low, high = (np.array([problem.ranges[name][k] for name in names]) for k in (0, 1))
    made = np.clip(made, low, high)
    return {name: made[:, k] for k, name in enumerate(names)}
