"""Stores of values for tests of single rules."""

from __future__ import annotations

import numpy as np

from cordicc.ir.graph import Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.field import Field
from cordicc.rewrite.exact.values import Store

NAMES = ("x", "y", "t", "c", "z")


def store_of_inputs() -> tuple[Store, dict[str, Value]]:
    """Return a store with inputs alone, and their values by name; (x, y) is never 0."""
    generator = np.random.default_rng(3)
    samples = {name: generator.uniform(-3.1, 3.1, 50) for name in NAMES}
    # Large enough a vector for every C, so that the equations have solutions.
    samples["x"] = np.copysign(4.0 + np.abs(samples["x"]), samples["x"])
    store = Store(Field(40, 20, 20), {name: Interval(-8.0, 8.0) for name in NAMES}, samples)
    return store, {name: store.make("input", (), (name,))[0] for name in NAMES}
