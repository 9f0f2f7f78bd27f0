"""Errors of a simulation against the original equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.emulate.histogram import Errors, angular
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.reference import reference_outputs


@dataclass(frozen=True, slots=True)
class Observed:
    """Errors over the samples valid in both the equations and the simulation; None without any.

    `max` and `rms` are absolute, in the unit of the output; of angles, modulo 2 pi.  `at` is the
    sample of the largest error.  `histogram` has the least error of each bin and its samples, see
    `Errors.rows`.
    """

    max: float | None
    rms: float | None
    at: int | None
    histogram: tuple[tuple[float, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Comparison:
    """A simulation beside the equations: errors by output, and where validity differs.

    `lost` samples are valid in the equations alone, `gained` ones in the simulation alone; `lost_at`
    is the first lost one.
    """

    observed: dict[str, Observed]
    samples: int
    valid: int
    lost: int
    gained: int
    lost_at: int | None


class ReferenceOutputs(NamedTuple):
    """What the equations say of samples: the outputs, float64 of shape (n,), and which are defined."""

    outputs: Mapping[str, NDArray[Any]]
    defined: NDArray[Any]


def exact(graph: Graph, inputs: Mapping[str, NDArray[Any]]) -> ReferenceOutputs:
    """Evaluate the equations as written on samples, float64 of shape (n,), in high precision."""
    return ReferenceOutputs(*reference_outputs(graph, inputs))


def errors(
    reference: ReferenceOutputs, angles: Mapping[str, bool], outputs: Mapping[str, NDArray[Any]]
) -> dict[str, NDArray[Any]]:
    """Return each output's errors, of angles modulo 2 pi, on the samples valid in both; see `compare`."""
    values, defined = reference
    both = defined & outputs["valid"].astype(bool)
    found = {}
    for name, is_angle in angles.items():
        found[name] = angular(outputs[name][both] - values[name][both], is_angle)
    return found


def compare(
    reference: ReferenceOutputs, angles: Mapping[str, bool], outputs: Mapping[str, NDArray[Any]]
) -> Comparison:
    """Compare simulated outputs with the high-precision evaluation of the equations.

    Args:
        reference: what the equations say of the samples.
        angles: by output, whether errors count modulo 2 pi.
        outputs: what the simulation gave for them, and its `valid`.
    """
    _, defined = reference
    simulated = outputs["valid"].astype(bool)
    both = defined & simulated
    observed = {}
    for name, error in errors(reference, angles, outputs).items():
        if error.size:
            where = int(np.argmax(error))
            bins = Errors()
            bins.add(error, np.arange(error.size), rank=False)
            at = int(np.flatnonzero(both)[where])
            observed[name] = Observed(float(error[where]), bins.rms, at, tuple(bins.rows()))
        else:
            observed[name] = Observed(None, None, None)
    return Comparison(
        observed,
        samples=len(defined),
        valid=int(simulated.sum()),
        lost=int((defined & ~simulated).sum()),
        gained=int((simulated & ~defined).sum()),
        lost_at=int(np.argmax(defined & ~simulated)) if (defined & ~simulated).any() else None,
    )
