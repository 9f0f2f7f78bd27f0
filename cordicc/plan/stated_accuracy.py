"""What a plan states of the accuracy of an output: errors that were seen, and a bound that is proven."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Predicate:
    """A condition under which a bound holds, on a sample.

    The margin of an operation is at least a threshold; or, without an operation, the sample's own bound is
    at most that.  `text` says it in words.
    """

    kind: str
    threshold: float
    text: str
    operation: str | None = None


@dataclass(frozen=True, slots=True)
class StatedBound:
    """A proven bound of an output's error, in the output's unit, angles modulo 2 pi.

    `where` says in words where it holds, `conditions` as data (None: only in words); `share_of_samples` is
    the part of the default samples for which it does, `own_bounds` within which bounds of their own so many
    of them are, by share, None where infinite.
    """

    value: float
    where: str
    share_of_samples: float
    conditions: tuple[Predicate, ...] | None = None
    own_bounds: Mapping[str, float | None] | None = None


@dataclass(frozen=True, slots=True)
class SeenErrors:
    """Errors on the default samples, in the output's unit, angles modulo 2 pi; None without a valid sample.

    `histogram` has the least error of each bin and its samples.
    """

    max: float | None
    rms: float | None
    histogram: tuple[tuple[float, int], ...] = ()


@dataclass(frozen=True, slots=True)
class AccuracyEnd:
    """Where an output may be wrong by more than `error`: where a denominator is below a size.

    `equation` says in words which equations divide by it, `denominator` is its name if it has one, else
    empty; constant factors are left out of it.  The largest error seen there is `worst`, at the inputs `at`.
    """

    equation: str
    denominator: str
    below: float
    error: float
    worst: float
    at: Mapping[str, float]

    @property
    def size(self) -> str:
        """The size of the denominator in words."""
        return f"|{self.denominator}|" if self.denominator else "the denominator"


@dataclass(frozen=True, slots=True)
class CheckFigures:
    """What a check showed on the default samples: how far it is from 0, in its own unit.

    `undefined` valid samples have no value in it; `worst_input` is the sample of the largest, by input.
    """

    observed: SeenErrors
    undefined: int = 0
    worst_input: Mapping[str, float] | None = None


@dataclass(frozen=True, slots=True)
class OutputAccuracy:
    """The accuracy of an output; `bound_reason` says why there is no bound where one was asked for.

    `ends` are where it was seen to end, near zeros of denominators.
    """

    observed: SeenErrors
    bound: StatedBound | None = None
    bound_reason: str = ""
    ends: tuple[AccuracyEnd, ...] = ()
