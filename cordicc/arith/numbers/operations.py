"""What adders, selectors and sign logic do, on floating-point numbers or on integers of one scale."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Bools


def _chosen(s: NDArray[Any], a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    return np.where(s >= 0, a, b)


EXACT: dict[str, Callable[..., NDArray[Any]]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "neg": lambda a: -a,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "flip": lambda a, s: _chosen(s, a, -a),
    "select": _chosen,
    "guard": lambda a, s: a,
}
"""Operations by name; what `guard` keeps is told by `kept`."""

_CONDITIONS: dict[object, Callable[[NDArray[Any], float], NDArray[Any]]] = {
    "any": lambda s, slack: np.ones(s.shape, dtype=bool),
    "nonzero": lambda s, slack: s != 0,
    "nonnegative": lambda s, slack: s >= -slack,
    "positive": lambda s, slack: s > 0,
}


def kept(condition: object, s: NDArray[Any], slack: float = 0) -> Bools:
    """Return where a guard's condition holds, or may hold but for rounding: a slack, in the unit of s.

    Raises ValueError for an unknown condition.
    """
    if condition not in _CONDITIONS:
        raise ValueError(f"unknown guard condition {condition!r}")
    return np.asarray(_CONDITIONS[condition](s, slack), dtype=bool)
