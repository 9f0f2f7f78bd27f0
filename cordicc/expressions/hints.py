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

_ROUNDING = ("floor", "ceil", "ceiling", "round", "trunc", "int", "mod", "fmod", "remainder", "rint")
_WRITTEN_OUT = {"radians": "x*deg for x degrees", "deg2rad": "x*deg for x degrees",
                "degrees": "x/deg for an angle in degrees", "rad2deg": "x/deg for an angle in degrees",
                "cot": "1/tan(x)", "sec": "1/cos(x)", "csc": "1/sin(x)", "square": "x**2"}  # fmt: skip

NO_CONDITIONALS = "conditionals are not supported; min, max, abs and sign often do instead"


def unit_hint(unit: str) -> str:
    """Return the hint for a unit written after a number."""
    if unit in ("rad", "radian", "radians"):
        return "angles are in radians: leave the unit out"
    return "only a number that stands alone takes a unit, as in 'l1: 5 mm'; convert others by hand"


def function_hint(name: str, functions: Iterable[str]) -> str:
    """Return the hint for an unknown function."""
    functions = list(functions)
    if name in KEYWORDS or name in ("ifelse", "select", "piecewise", "Piecewise"):
        return NO_CONDITIONALS
    if name in _ROUNDING:
        return "expressions are not rounded; atan2(sin(x), cos(x)) wraps an angle"
    if name in _WRITTEN_OUT:
        return f"write {_WRITTEN_OUT[name]}"
    aliases = {"ln": "log", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2",
               "Abs": "abs", "sgn": "sign", "power": "**", "pow": "**"}  # fmt: skip
    near = [aliases[name]] if name in aliases else get_close_matches(name, functions, 3, 0.5)
    if near:
        return "did you mean " + " or ".join(f"'{n}'" for n in near) + "?"
    return "the functions are " + ", ".join(functions) + "; a product is written with '*'"


def signature(name: str) -> str:
    """Return the hint that shows how a function is called."""
    forms = {"atan2": "atan2(y, x)", "hypot": "hypot(x, y)", "min": "min(a, b, ...)", "max": "max(a, b, ...)",
             "vector": "vector(x, y, z)", "dot": "dot(u, v)", "cross": "cross(u, v)", "norm": "norm(v)",
             "rotate": "rotate(v, axis, angle), axis x, y or z; in the plane rotate(v, angle)"}  # fmt: skip
    return "write " + forms.get(name, f"{name}(x)")
