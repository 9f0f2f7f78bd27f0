"""Number systems by name, built from the plain data of targets and plans."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import NumberSystem

_KEYS = {"ieee-single": (set(), set()), "fixed-point": ({"width"}, {"guard", "rounding"})}


def system_from_spec(spec: Mapping[str, Any]) -> NumberSystem:
    """Build a number system from its plain-data form.  Raises ValueError."""
    kind = spec.get("kind") if isinstance(spec, Mapping) else None
    if not isinstance(kind, str) or kind not in _KEYS:
        raise ValueError(f"the number format needs a 'kind' (known: {', '.join(_KEYS)})")
    required, optional = _KEYS[kind]
    keys = set(spec) - {"kind"}
    if missing := sorted(required - keys):
        raise ValueError(f"the number format {kind} lacks {', '.join(missing)}")
    if unknown := sorted(str(key) for key in keys - required - optional):
        raise ValueError(f"the number format {kind} has unknown keys: {', '.join(unknown)}")
    if kind == "ieee-single":
        return SingleSystem()
    width, guard = spec["width"], spec.get("guard", 0)
    if type(width) is not int or type(guard) is not int:
        raise ValueError("the widths of a number format are integers")
    return FixedSystem(width, guard, spec.get("rounding", "half-up"))
