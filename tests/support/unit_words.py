"""Words for tests of units: random, tiny, huge, equal, opposite, zero and invalid ones."""

from __future__ import annotations

from typing import Any

import numpy as np

from cordicc.arith.unit.cau import Cau

UNITS = {
    "24-stage": Cau(29, 24, "single-rotation", 24, 32),
    "single": Cau(29, 30, "single-rotation", 24, 32),
    "root-free": Cau(29, 30, "root-free", 24, 32),
    "widest": Cau(40, 40, "single-rotation", 32, 44),
    "widest root-free": Cau(40, 40, "root-free", 32, 44),
    "narrow": Cau(20, 16, "root-free", 16, 20),
    "narrowest": Cau(8, 8, "single-rotation", 6, 8),
    "odd": Cau(31, 28, "single-rotation", 24, 36),
}

OPERATIONS: tuple[tuple[str, tuple[Any, ...]], ...] = (
    *(("rotate", (m,)) for m in (1, 0, -1)),
    *(("vector", (m, sign)) for m in (1, 0, -1) for sign in (1, -1)),
    ("lightcone", ()),
    *(("implicit", (1, branch)) for branch in "+-"),
    *(("implicit", (-1, branch)) for branch in ("+", "-", "none")),
)


def words(generator: np.random.Generator, count: int, bits: int) -> np.ndarray:
    """Return float64 values of at most `bits` significant bits."""
    kind = generator.integers(0, 6, count)
    mantissa = generator.integers(-(1 << (bits - 1)) + 1, 1 << (bits - 1), count).astype(float)
    far, near = generator.integers(-160, 100, count), generator.integers(-3, 4, count)
    exponent = np.select(
        [kind == 0, kind == 1, kind == 2], [far, near, 0 * near], generator.integers(-12, 6, count)
    )
    values = np.ldexp(mantissa, exponent - bits + 1)
    for share, value in ((0.03, 0.0), (0.01, np.nan), (0.03, 1.0)):
        values[generator.random(count) < share] = value
    return values


def operands(seed: int, count: int, bits: int) -> list[np.ndarray]:
    """Return three operands: some equal or opposite, a third of the last within the norm of the others."""
    generator = np.random.Generator(np.random.PCG64(seed))
    x, y, z = (words(generator, count, bits) for _ in range(3))
    for sign in (1, -1):
        same = generator.random(count) < 0.1
        y[same] = sign * x[same]
    with np.errstate(over="ignore", invalid="ignore"):
        reached = np.sqrt(x * x + y * y) * generator.uniform(-1, 1, count)
        inside = (generator.random(count) < 0.3) & (np.abs(reached) < 8)
    z[inside] = np.ldexp(np.rint(np.ldexp(reached[inside], bits - 4)), 4 - bits)
    return [x, y, z]


def results(unit: Cau, name: str, params: tuple[Any, ...], values: list[np.ndarray]) -> list[np.ndarray]:
    """Run an operation; return the bits of its results, one pattern for NaN."""
    taken = values[:2] if name == "lightcone" else values
    made = getattr(unit, name)(*params, *taken)
    return [np.where(np.isnan(each), np.nan, each).view(np.int64) for each in made]
