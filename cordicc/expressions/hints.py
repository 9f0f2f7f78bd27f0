"""What to write instead of words that expressions do not have."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_WORDS = "if then elif else for while and or not in is lambda where"
KEYWORDS = frozenset(_WORDS.split())
"""Words that are operators elsewhere; they are ordinary names here."""

_UNIT_NAMES = """
mm cm dm m km um nm inch inches ft s ms us min h Hz kHz g kg N Nm V A rad mrad radian radians
"""
UNITS = frozenset(_UNIT_NAMES.split())
"""Units that are written after a number elsewhere."""

FOREIGN = {
    "^": "use '**' for a power",
    "==": "use '=' between the sides of an equation",
    "!=": "there is no such relation here",
    "//": "use '/' for a quotient",
    "&&": "there are no logical operators",
    "||": "there are no logical operators; use abs(...) for the magnitude",
}
"""Operators of other languages, and what to write instead."""

_ROUNDING = ("floor", "ceil", "ceiling", "round", "trunc", "int", "mod", "fmod", "remainder", "rint")
_WRITTEN_OUT = {"radians": "x*deg for x degrees", "deg2rad": "x*deg for x degrees",
                "degrees": "x/deg for an angle in degrees", "rad2deg": "x/deg for an angle in degrees",
                "cot": "1/tan(x)", "sec": "1/cos(x)", "csc": "1/sin(x)", "square": "x**2"}  # fmt: skip

_ANGLE = "atan2(y, x) is the angle of the vector (x, y)"
NO_CONDITIONALS = "conditionals are not supported; min, max, abs and sign often do instead"


def unit_hint(unit: str) -> str:
    """Return the hint for a unit written after a number."""
    if unit in ("rad", "radian", "radians"):
        return "angles are in radians: leave the unit out"
    return "only a number that stands alone takes a unit, as in 'l1: 5 mm'; convert others by hand"


def argument_count(texts: Iterable[str]) -> int:
    """Return how many arguments a call has, given the texts of the tokens from its bracket on."""
    depth, commas, last = 0, 0, ""
    for text in texts:
        depth += (text in ("(", "[")) - (text in (")", "]"))
        if depth == 0:
            return commas + (last != "(")
        commas += text == "," and depth == 1
        last = text
    return 0


def function_hint(name: str, functions: Iterable[str], count: int = 1) -> str:
    """Return the hint for an unknown function, called with so many arguments."""
    functions = list(functions)
    if name in KEYWORDS or name in ("ifelse", "select", "piecewise", "Piecewise"):
        return NO_CONDITIONALS
    if name in _ROUNDING:
        return "expressions are not rounded; atan2(sin(x), cos(x)) wraps an angle"
    if name in _WRITTEN_OUT:
        return f"write {_WRITTEN_OUT[name]}"
    aliases = {"ln": "log", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2",
               "Abs": "abs", "sgn": "sign", "power": "**", "pow": "**"}  # fmt: skip
    if count == 2 and aliases.get(name) == "atan":
        return "did you mean 'atan2'? " + _ANGLE
    near = [aliases[name]] if name in aliases else get_close_matches(name, functions, 3, 0.5)
    if near:
        return "did you mean " + " or ".join(f"'{n}'" for n in near) + "?"
    return "the functions are " + ", ".join(functions) + "; a product is written with '*'"


def signature(name: str, count: int) -> str:
    """Return the hint that shows how a function is called that has so many arguments, which is wrong."""
    if name == "atan" and count == 2:
        return _ANGLE
    forms = {"atan2": "atan2(y, x)", "hypot": "hypot(x, y)", "min": "min(a, b, ...)", "max": "max(a, b, ...)",
             "vector": "vector(x, y, z)", "dot": "dot(u, v)", "cross": "cross(u, v)", "norm": "norm(v)",
             "rotate": "rotate(v, axis, angle), axis x, y or z; in the plane rotate(v, angle)"}  # fmt: skip
    return "write " + forms.get(name, f"{name}(x)")
