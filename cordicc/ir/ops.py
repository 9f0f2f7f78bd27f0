"""The operations of the graph: one table, one screen.

Three vocabularies share one graph.  *Leaves* and *arithmetic* occur from the equations to the plan;
*functions* are what a user writes and are gone after selection; *unit operations* are what a CORDIC
arithmetic unit (CAU) does in one pass, with two results.

m is the coordinate system: 1 circular, 0 linear, -1 hyperbolic (Walther).  "Partial" operations have
inputs without a value; such a sample is invalid, and an invalid operand makes every result invalid.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Level(StrEnum):
    """The vocabulary an operation belongs to."""

    LEAF = "leaf"
    ARITHMETIC = "arithmetic"
    FUNCTION = "function"
    UNIT = "unit"


@dataclass(frozen=True, slots=True)
class OpDef:
    """An operation: the names of its operand ports, of its parameters and of its results.

    `angle` is the number of the result that is an angle: in radians in a circular system, which functions
    are in that have no parameter m, and without a unit in a hyperbolic one.
    """

    name: str
    level: Level
    ports: tuple[str, ...]
    params: tuple[str, ...]
    results: tuple[str, ...]
    meaning: str
    commutative: bool = False
    partial: bool = False
    angle: int | None = None
    hyperbolic: bool = False

    @property
    def arity(self) -> int:
        """Return the number of operands."""
        return len(self.ports)

    def named(self, params: Sequence[Any]) -> dict[str, Any]:
        """Return parameters in the order of the definition by their names."""
        return dict(zip(self.params, params, strict=True))


def _op(name: str, level: str, ports: str, params: str, results: str, meaning: str, **more: Any) -> OpDef:
    names = tuple(results.split()) or ("value",)
    return OpDef(name, Level(level), tuple(ports.split()), tuple(params.split()), names, meaning, **more)


# fmt: off
_TABLE = (
    # name, level, operands, parameters, results, meaning
    _op("input", "leaf", "", "name", "", "an input of the problem"),
    _op("const", "leaf", "", "value", "", "a rational constant"),
    _op("add", "arithmetic", "a b", "", "", "a + b", commutative=True),
    _op("sub", "arithmetic", "a b", "", "", "a - b"),
    _op("mul", "arithmetic", "a b", "", "", "a b", commutative=True),
    _op("cmul", "arithmetic", "a", "factor", "", "factor * a, factor constant"),
    _op("shift", "arithmetic", "a", "exponent", "", "a * 2**exponent"),
    _op("neg", "arithmetic", "a", "", "", "-a"),
    _op("abs", "arithmetic", "a", "", "", "|a|"),
    _op("sign", "arithmetic", "a", "", "", "-1, 0 or 1"),
    _op("min", "arithmetic", "a b", "", "", "the smaller of a, b", commutative=True),
    _op("max", "arithmetic", "a b", "", "", "the larger of a, b", commutative=True),
    _op("flip", "arithmetic", "a s", "", "", "a if s >= 0 else -a"),
    _op("select", "arithmetic", "s a b", "", "", "a if s >= 0 else b"),
    _op("guard", "arithmetic", "a s", "condition", "", "a; invalid unless s is as told", partial=True),
    _op("wrap", "arithmetic", "a", "", "", "a modulo 2 pi, in (-pi, pi]"),
    _op("div", "function", "a b", "", "", "a / b", partial=True),
    _op("pow", "function", "a", "exponent", "", "a**exponent, a multiple of 1/2", partial=True),
    _op("sqrt", "function", "a", "", "", "the square root", partial=True),
    _op("hypot", "function", "a b", "", "", "sqrt(a**2 + b**2)", commutative=True),
    _op("sin", "function", "a", "", "", "sine"),
    _op("cos", "function", "a", "", "", "cosine"),
    _op("tan", "function", "a", "", "", "tangent", partial=True),
    _op("asin", "function", "a", "", "", "arc sine", partial=True, angle=0),
    _op("acos", "function", "a", "", "", "arc cosine", partial=True, angle=0),
    _op("atan", "function", "a", "", "", "arc tangent", angle=0),
    _op("atan2", "function", "y x", "", "", "the angle of the vector (x, y)", partial=True, angle=0),
    _op("sinh", "function", "a", "", "", "hyperbolic sine"),
    _op("cosh", "function", "a", "", "", "hyperbolic cosine"),
    _op("tanh", "function", "a", "", "", "hyperbolic tangent"),
    _op("asinh", "function", "a", "", "", "inverse hyperbolic sine"),
    _op("acosh", "function", "a", "", "", "inverse hyperbolic cosine", partial=True),
    _op("atanh", "function", "a", "", "", "inverse hyperbolic tangent", partial=True),
    _op("exp", "function", "a", "", "", "exponential"),
    _op("log", "function", "a", "", "", "natural logarithm", partial=True),
    _op("solve", "function", "A B C", "m branch", "",
        "t with B cos t + A sin t = C (m=-1: cosh, sinh)", partial=True, angle=0),
    _op("solve_pair", "function", "A1 B1 C1 A2 B2 C2", "", "",
        "atan2(s, c) with B1 c + A1 s = C1, B2 c + A2 s = C2", partial=True, angle=0),
    _op("rotate", "unit", "x y z", "m", "x y", "(x, y) turned by z: x C - m y S, y C + x S"),
    _op("vector", "unit", "x y z", "m sign", "norm angle",
        "sqrt(x**2 + m y**2), z + sign * angle of (x, y); m=0: x, z + sign * y/x", partial=True, angle=1),
    _op("lightcone", "unit", "u v", "", "root angle",
        "hyperbolic vectoring of x+y=u, x-y=v: sqrt(u v), log(u/v)/2",
        partial=True, angle=1, hyperbolic=True),
    _op("implicit", "unit", "A B C", "m branch", "angle rest",
        "t as for solve, and sqrt(A**2 + m B**2 - m C**2)", partial=True, angle=0),
)
# fmt: on

OPS: dict[str, OpDef] = {definition.name: definition for definition in _TABLE}


def has_border(op: str, params: Mapping[str, Any]) -> bool:
    """Tell whether the domain of an operation of a plan includes a border that rounding may cross.

    There the result is 0 or the end of reach; a pole is no such border.
    """
    match op:
        case "implicit" | "lightcone":
            return True
        case "vector":
            return params.get("m") == -1
        case "guard":
            return params.get("condition") == "nonnegative"
    return False


GUARD_CONDITIONS = ("any", "nonzero", "nonnegative", "positive")
BRANCHES = ("+", "-", "none")


def angle_result(op: str, params: Mapping[str, Any], m: int = 1) -> int | None:
    """Return the number of the result that is an angle in a coordinate system, None if none is.

    Args:
        op: the name of an operation.
        params: its parameters by name.
        m: the system; angles in the circular one are in radians.
    """
    definition = OPS[op]
    own = params.get("m", -1 if definition.hyperbolic else 1)
    return definition.angle if own == m else None
