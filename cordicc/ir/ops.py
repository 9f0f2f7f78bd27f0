"""The operations of the graph: one table, one screen.

Three vocabularies share one graph.  *Leaves* and *arithmetic* occur from the equations to the plan;
*functions* are what a user writes and are gone after selection; *unit operations* are what a CORDIC
arithmetic unit (CAU) does in one pass, with two results.

m is the coordinate system: 1 circular, 0 linear, -1 hyperbolic (Walther).  "Partial" operations have
inputs without a value; such a sample is invalid, and an invalid operand makes every result invalid.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Level(StrEnum):
    LEAF = "leaf"
    ARITHMETIC = "arithmetic"
    FUNCTION = "function"
    UNIT = "unit"


@dataclass(frozen=True, slots=True)
class OpDef:
    """An operation: its operand count, the names of its parameters and of its results."""

    name: str
    level: Level
    arity: int
    params: tuple[str, ...] = ()
    results: tuple[str, ...] = ("value",)
    commutative: bool = False
    partial: bool = False
    meaning: str = ""


_LEAF, _ARITH, _FN, _UNIT = Level.LEAF, Level.ARITHMETIC, Level.FUNCTION, Level.UNIT

_TABLE = (
    OpDef("input", _LEAF, 0, ("name",), meaning="an input of the problem"),
    OpDef("const", _LEAF, 0, ("value",), meaning="a rational constant"),
    OpDef("add", _ARITH, 2, commutative=True, meaning="a + b"),
    OpDef("sub", _ARITH, 2, meaning="a - b"),
    OpDef("mul", _ARITH, 2, commutative=True, meaning="a b"),
    OpDef("cmul", _ARITH, 1, ("factor",), meaning="factor * a, factor constant"),
    OpDef("shift", _ARITH, 1, ("exponent",), meaning="a * 2**exponent"),
    OpDef("neg", _ARITH, 1, meaning="-a"),
    OpDef("abs", _ARITH, 1, meaning="|a|"),
    OpDef("sign", _ARITH, 1, meaning="-1, 0 or 1"),
    OpDef("min", _ARITH, 2, commutative=True, meaning="the smaller of a, b"),
    OpDef("max", _ARITH, 2, commutative=True, meaning="the larger of a, b"),
    OpDef("flip", _ARITH, 2, meaning="a if s >= 0 else -a"),
    OpDef("select", _ARITH, 3, meaning="a if s >= 0 else b, for operands (s, a, b)"),
    OpDef("guard", _ARITH, 2, ("condition",), partial=True, meaning="a, invalid unless s is any|nonzero|nonnegative|positive"),
    OpDef("wrap", _ARITH, 1, meaning="a modulo 2 pi, in (-pi, pi]"),
    OpDef("div", _FN, 2, partial=True, meaning="a / b"),
    OpDef("pow", _FN, 1, ("exponent",), partial=True, meaning="a**exponent, exponent a multiple of 1/2"),
    OpDef("sqrt", _FN, 1, partial=True),
    OpDef("hypot", _FN, 2, commutative=True, meaning="sqrt(a**2 + b**2)"),
    OpDef("sin", _FN, 1),
    OpDef("cos", _FN, 1),
    OpDef("tan", _FN, 1, partial=True),
    OpDef("asin", _FN, 1, partial=True),
    OpDef("acos", _FN, 1, partial=True),
    OpDef("atan", _FN, 1),
    OpDef("atan2", _FN, 2, partial=True, meaning="the angle of the vector (b, a)"),
    OpDef("sinh", _FN, 1),
    OpDef("cosh", _FN, 1),
    OpDef("tanh", _FN, 1),
    OpDef("asinh", _FN, 1),
    OpDef("acosh", _FN, 1, partial=True),
    OpDef("atanh", _FN, 1, partial=True),
    OpDef("exp", _FN, 1),
    OpDef("log", _FN, 1, partial=True),
    OpDef("solve", _FN, 3, ("m", "branch"), partial=True, meaning="t with B cos t + A sin t = C (m=1; cosh, sinh for m=-1), operands (A, B, C)"),
    OpDef("solve_pair", _FN, 6, partial=True, meaning="atan2(s, c) with B1 c + A1 s = C1, B2 c + A2 s = C2, operands (A1, B1, C1, A2, B2, C2)"),
    OpDef("rotate", _UNIT, 3, ("m",), ("x", "y"), meaning="(x, y) turned by z: x C - m y S, y C + x S"),
    OpDef("vector", _UNIT, 3, ("m", "sign"), ("norm", "angle"), partial=True, meaning="sqrt(x**2 + m y**2), z + sign * angle of (x, y); m=0: x, z + sign * y/x"),
    OpDef("lightcone", _UNIT, 2, (), ("root", "angle"), partial=True, meaning="hyperbolic vectoring of x+y=u, x-y=v: sqrt(u v), log(u/v)/2"),
    OpDef("implicit", _UNIT, 3, ("m", "branch"), ("angle", "rest"), partial=True, meaning="t of solve, and sqrt(A**2 + m B**2 - m C**2) >= 0"),
)

OPS: dict[str, OpDef] = {definition.name: definition for definition in _TABLE}

GUARD_CONDITIONS = ("any", "nonzero", "nonnegative", "positive")
BRANCHES = ("+", "-", "none")
