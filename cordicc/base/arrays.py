"""The names of NumPy's arrays by what they hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bools = NDArray[np.bool_]
Int64s = NDArray[np.int64]

Samples = Mapping[str, Floats]
"""A number of each sample by name, such as those of the inputs; all of one shape (n,)."""

Integers = NDArray[Any]
"""int64, or Python's integers, in arrays of objects, where these are too narrow."""

Words = NDArray[Any]
"""Words of a number format, in arrays of the format's own type."""
