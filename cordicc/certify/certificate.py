"""The proven bound of every output of a plan, and where it holds.

Most plans have no singular operation within their ranges: what is proven of the margins then holds for every
valid sample, and the bound is proven over the whole box of inputs. Where a margin may vanish the bound
demands one. If many margins meet, a box is too coarse a way to say where an output is well conditioned:
then the bound demands the sample's own bound, which is as rigorous, to be no larger.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.base.arrays import Bools, Floats
from cordicc.certify.boxes import Boxes
from cordicc.certify.error_network import ErrorNetwork, Step
from cordicc.certify.predicates import margin, own_bound, singular
from cordicc.certify.refine import Search, largest
from cordicc.certify.sweep import Forward, errors, forward, least_square
from cordicc.emulate.climb import climb_all, climbing
from cordicc.plan.stated_accuracy import Predicate

_OCTAVES = 11
"""A margin 2^-11 of the median is demanded, an own bound 2^11 of the median is allowed.

Sensitivity grows as the reciprocal of the distance from a singularity, so about a thousandth of samples is
outside, and few even of those that come near it more often than the default ones do.
"""

_STEP_BOXES = 6_000_000
"""Operations times boxes that may be evaluated for all outputs together."""

_MARGIN_STEP_BOXES = 2_000_000
"""The same for the proofs that no margin needs to be demanded."""

_MOST_BOXES = 16_000
"""Boxes for one bound or proof."""

_ENOUGH = 1.2
"""A bound this much larger than the largest own bound that was found is not improved."""

_LOOSE = 4.0
"""A bound more than this much larger gives way to the demand of an own bound."""

_SHARE = 0.99
"""Of samples that must meet what is wanted of their own bounds."""

_HOPELESS = 100.0
"""A bound still this much larger after an eighth of the boxes is given up, where conditions are needed."""

_STEEP = 8.0
"""Own bounds that exceed their median by more than this grow towards a singularity."""

_CLIMBERS = 64
_CLIMBS = 72


@dataclass(frozen=True, slots=True)
class Bound:
    """The proven bound of an output's error and the predicates under which it holds; None with a reason."""

    value: float | None
    where: tuple[Predicate, ...]
    reason: str | None = None


def certify(
    net: ErrorNetwork,
    samples: Mapping[str, Floats],
    valid: Bools,
    wanted: Mapping[str, float] | None = None,
) -> dict[str, Bound]:
    """Return the bound of every output.

    Args:
        net: the plan's operations.
        samples: of the inputs, float64 of shape (n,), by which thresholds are chosen.
        valid: which of them the plan computes.
        wanted: by output, a bound that suffices; where conditions are needed anyway, the sample's own bound
            is demanded to be no larger if 99 % of samples meet that.
    """
    if not valid.any():
        return {output: Bound(None, (), "no sample is valid") for output in net.outputs}
    kept = {name: samples[name][valid] for name in net.inputs}
    points = {name: Boxes(column, column) for name, column in kept.items()}
    seen = forward(net, net.steps, points, {})
    demanded, proven = _margins(net, {i: np.sqrt(np.maximum(s.lo, 0)) for i, s in seen.squares.items()})
    goals = wanted or {}
    outputs = tuple(net.outputs)
    found = _largest_own(net, outputs, kept, demanded)
    boxes = {o: _over_boxes(net, o, demanded, proven, found[o], goals.get(o)) for o in outputs}
    loose = [o for o in outputs if not boxes[o].suffices]
    alone = _largest_own(net, loose, kept, {}) if loose else {}
    bounds = {}
    for output in outputs:
        bounds[output] = boxes[output].bound
        if output in alone:
            own = _own(net, output, seen, {})
            bounds[output] = boxes[output].or_better(_conditioned(own, alone[output], goals.get(output)))
    return bounds


def _margins(net: ErrorNetwork, seen: Mapping[str, Floats]) -> tuple[dict[str, float], dict[str, float]]:
    """Return by operation the least margin: what must be demanded, and what is proven."""
    demanded: dict[str, float] = {}
    proven: dict[str, float] = {}
    steps = [step for step in net.steps if singular(step)]
    for step in steps:
        margins = seen[step.id]
        least = float(margins.min(initial=math.inf)) / 4
        if 0 < least < math.inf and _keeps(net, step, least, {**demanded, **proven}, len(steps)):
            proven[step.id] = least
        elif margins.size:
            demanded[step.id] = _short(float(np.median(margins)) * 2.0**-_OCTAVES)
    return demanded, proven


def _keeps(net: ErrorNetwork, step: Step, least: float, known: Mapping[str, float], sharing: int) -> bool:
    """Tell whether it is proven that an operation's margin is never smaller."""
    steps = net.before(step)
    names = [name for name in net.inputs if name in net.needed(steps, step.operands)]

    def missing(boxes: Mapping[str, Boxes]) -> Floats:
        low, empty = least_square(net, steps, boxes, known)
        return np.where(empty | (low >= least * least), -np.inf, 1.0 - np.minimum(low, 0.0))

    boxes = min(_MOST_BOXES, _MARGIN_STEP_BOXES // (sharing * len(steps)))
    return largest(net.inputs, names, missing, Search(0.0, boxes)) <= 0


def _short(number: float) -> float:
    """Return a number with three digits, not above."""
    if number <= 0:
        return 0.0
    scale = 10.0 ** (math.floor(math.log10(number)) - 2)
    return float(f"{math.floor(number / scale) * scale:.3g}")


def _largest_own(
    net: ErrorNetwork, outputs: Sequence[str], samples: Mapping[str, Floats], demanded: Mapping[str, float]
) -> dict[str, float]:
    """Return the largest own bound of each output that a search finds where the margins are as demanded."""

    def heights(each: Sequence[Mapping[str, Floats]]) -> list[Floats]:
        together = {name: np.concatenate([points[name] for points in each]) for name in net.inputs}
        made = forward(net, net.steps, {name: Boxes(c, c) for name, c in together.items()}, {})
        found, start = [], 0
        for output, points in zip(outputs, each, strict=True):
            own = _own(net, output, made, demanded)
            end = start + len(next(iter(points.values())))
            found.append(np.where(np.isfinite(own), own, -np.inf)[start:end])
            start = end
        return found

    searches = [climbing(net.inputs, samples, climbers=_CLIMBERS, rounds=_CLIMBS) for _ in outputs]
    tops = climb_all(searches, heights)
    return {output: float(top.max(initial=0.0)) for output, (_, top) in zip(outputs, tops, strict=True)}


@dataclass(frozen=True, slots=True)
class _OverBoxes:
    """The bound where margins are as demanded, infinite if there is none; and whether it is good enough."""

    value: float
    where: tuple[Predicate, ...]
    suffices: bool

    @property
    def bound(self) -> Bound:
        return Bound(self.value, self.where)

    def or_better(self, other: Bound) -> Bound:
        """Return this bound, or the other one if it is smaller."""
        if math.isfinite(self.value) and (other.value is None or other.value >= self.value):
            return self.bound
        return other


def _over_boxes(
    net: ErrorNetwork,
    output: str,
    demanded: Mapping[str, float],
    proven: Mapping[str, float],
    found: float,
    wanted: float | None,
) -> _OverBoxes:
    """Return the bound by a subdivision of the inputs' ranges; `found` is the largest own bound found."""
    steps = net.upstream(output)
    names = [name for name in net.inputs if name in net.needed(steps, (net.outputs[output],))]
    where = tuple(margin(s, demanded[s.id]) for s in steps if demanded.get(s.id))
    known = {s.id: demanded.get(s.id) or proven.get(s.id, 0.0) for s in steps if singular(s)}

    def over(boxes: Mapping[str, Boxes]) -> Floats:
        return errors(net, steps, output, forward(net, steps, boxes, known))

    boxes = min(_MOST_BOXES, _STEP_BOXES // ((len(steps) + 1) * len(net.outputs)))
    if where and largest(net.inputs, names, over, Search(_HOPELESS * found, boxes // 8)) > _HOPELESS * found:
        boxes = 0
    enough = _ENOUGH * found if wanted is None or wanted < found else min(_ENOUGH * found, wanted)
    value = largest(net.inputs, names, over, Search(enough, boxes)) if boxes else math.inf
    within = value <= _LOOSE * found and not (wanted is not None and value > wanted)
    return _OverBoxes(value, where, math.isfinite(value) and (within or not where))


def _own(net: ErrorNetwork, output: str, made: Forward, demanded: Mapping[str, float]) -> Floats:
    """Return the own bounds of samples by their forward sweep, -inf where a margin is less than demanded."""
    steps = net.upstream(output)
    own = errors(net, steps, output, made)
    for step in steps:
        if demanded.get(step.id):
            own = np.where(made.squares[step.id].lo >= demanded[step.id] ** 2, own, -np.inf)
    return own


def _conditioned(own: Floats, found: float, wanted: float | None) -> Bound:
    """Return the bound that demands as much of the sample's own: what is wanted, if most samples meet it.

    Else 2^11 of the median, or less if no sample was found to come near that: 4 times what was found if there
    is no sign of a singularity, 16 times if there is, since then the search may have stopped short of it.
    """
    finite = own[np.isfinite(own)]
    if 2 * finite.size < own.size or not finite.size:
        return Bound(None, (), "fewer than half of the samples have a finite bound of their own")
    if wanted is not None and float(np.mean(own <= wanted)) >= _SHARE:
        return Bound(wanted, (own_bound(wanted),))
    median = float(np.median(finite))
    beyond = _LOOSE if found <= _STEEP * median else _LOOSE * _LOOSE
    value = _short(min(median * 2.0**_OCTAVES, beyond * found))
    return Bound(value, (own_bound(value),))
