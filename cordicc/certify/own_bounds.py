"""What is proven of single samples: their own bounds, and whether they are where a plan's bounds hold.

The samples are valid in the equations and in the simulation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cordicc.base.arrays import Bools, Floats, Samples
from cordicc.certify.boxes import Boxes
from cordicc.certify.error_network import ErrorNetwork
from cordicc.certify.predicates import meets
from cordicc.certify.sweep import Forward, errors, forward
from cordicc.plan.stated_accuracy import Predicate

_LEAST_BLOCK, _MOST_BLOCK = 256, 8192
_STEP_SAMPLES = 500_000
"""Steps times samples judged at once: enough to hide the cost of NumPy calls, few enough for the memory."""


def own_bounds(net: ErrorNetwork, outputs: Sequence[str], samples: Samples) -> dict[str, Floats]:
    """Return, by output, the proven bound of each sample's own error; inf where there is none.

    nan stands for a sample that is proven to be invalid in the equations.
    """
    found = {name: np.empty(_count(samples)) for name in outputs}
    for block, made in _sweeps(net, samples):
        for name, column in found.items():
            own = errors(net, net.upstream(name), name, made)
            column[block] = np.where(own < 0, np.nan, own)
    return found


def inside(
    net: ErrorNetwork, conditions: Mapping[str, Sequence[Predicate]], samples: Samples
) -> dict[str, Bools]:
    """Return, by output, which samples meet the conditions of its bound."""
    found = {name: np.ones(_count(samples), dtype=bool) for name in conditions}
    for block, made in _sweeps(net, samples) if any(conditions.values()) else ():
        for name, wanted in conditions.items():
            if wanted:
                found[name][block] = meets(net, name, wanted, made)
    return found


def _count(samples: Samples) -> int:
    return len(next(iter(samples.values()))) if samples else 1


def _sweeps(net: ErrorNetwork, samples: Samples) -> Iterator[tuple[slice, Forward]]:
    """Yield the forward sweep of each block of samples."""
    size = min(_MOST_BLOCK, max(_LEAST_BLOCK, _STEP_SAMPLES // (len(net.steps) + 1)))
    for begin in range(0, _count(samples), size):
        block = slice(begin, begin + size)
        points = {name: Boxes(samples[name][block], samples[name][block]) for name in net.inputs}
        yield block, forward(net, net.steps, points, {})
