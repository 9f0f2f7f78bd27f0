"""The slack of operations with a border: how far errors of the operands may carry a sample across it.

Where the equations are at the border, |C| = R or a root of 0, the words are beside it, and beyond it as often
as not. Their distance is at most that of the operands' errors, which the forward sweep bounds: over the whole
ranges for every sample, and for each sample alone. The former is enough for all, but where ranges are wide it
may be far from what any sample has. So samples next to the border are looked at, large and small ones. Where
their errors are alike, in the operands' unit or relative to the operands, the slack is `_ENOUGH` times what
is proven of nine in ten of them; else it is no more than most of them need, so that no sample is taken for
one at the border that is farther from it than its own errors. Where an error makes an operation choose
otherwise, what it chooses is right beside the sample, and errs as little: such a jump is no distance, nor is
a whole turn.  An error as large as what is compared tells that its sample is lost, and nothing of a border.

Before the end of reach a slack takes solutions away, so what counts as the end there is no more than what
half of the samples need, or as much where many of them are at the border, as by a clamp.

Rounding is monotone. So words of one format that nothing but rounding has made, of inputs and exact
constants, are on the right side of one another, and an operation on such operands has no slack.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.formats import NumberFormat
from cordicc.arith.numbers.slack import EXACT, SIZES, Slack
from cordicc.base.arrays import Bools, Floats
from cordicc.certify.boxes import Boxes, times
from cordicc.certify.error_network import Constant, ErrorNetwork, Step, known_norm, network
from cordicc.certify.sweep import Forward, forward
from cordicc.certify.unit_models import end_residual
from cordicc.ir.ops import angle_result, has_border
from cordicc.ir.sampling import draw_by_size, draw_with_corners
from cordicc.plan.model import EndError, Plan

_SAMPLES = 2_000
_NEAREST = 20
"""The share of samples next to a border is one in so many."""

_MOST = 0.9
"""The share of these whose operands have errors within what is taken."""

_ENOUGH = 2.0

_SMALL = 2.0**-16
"""An error that is small beside an operand, as a share of it."""

_TELLING = 2.0**-8
"""An error tells how far rounding carries samples if it is no larger a share of what is compared."""

_ALIKE = 32.0
"""Errors are alike if nine in ten are at most so many times as large as one in twenty is."""

_LEAST = 0.05
"""The share of samples whose errors may be below a slack where they are not alike."""

_NEAR = 2.0**-6
"""Samples come near the end of reach where R - |C| is no larger a share of the size."""

_MONOTONE = ("neg", "abs", "min", "max", "guard")
"""Operations that keep words on the right side of one another."""


def with_borders(plan: Plan) -> Plan:
    """Return a plan that holds its unit program, with what its operations have at the border of their domain.

    That is the slack of each that has one, and the error of an angle at the end of reach.
    """
    if not any(has_border(operation.op, operation.params) for operation in plan.operations):
        return plan
    net = network(plan)
    if not net.inputs:
        return plan
    points = _points(plan)
    samples = {name: Boxes(points[name], points[name]) for name in net.inputs}
    alone = forward(net, [_uncut(step) for step in net.steps], samples, {}, jumps=False)
    ranges = {name: Boxes(np.array([i.lo]), np.array([i.hi])) for name, i in net.inputs.items()}
    steady = forward(net, net.steps, ranges, {}, jumps=False)
    whole = forward(net, net.steps, ranges, {})
    rounded = _rounded_only(net)
    # Words of fixed point err by as much whatever their size.
    fixed_point = any(isinstance(format_, FixedPoint) for format_ in net.formats.values.values())
    operations = []
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of unbounded intervals
        for operation, step in zip(plan.operations, net.steps, strict=True):
            assert operation.id == step.id
            if has_border(step.op, step.params):
                valid = ~alone.empty(net.before(step))
                near, far = _distance(net, step, alone, valid), _distance(net, step, steady, np.array([True]))
                border = _Border(step, near, far)
                slack = EXACT if _monotone(step, rounded) else border.slack(scaled=not fixed_point)
                operation = replace(operation, slack=slack)
                if step.op == "implicit":
                    boxes = [whole.operand(operand)[0] for operand in step.operands]
                    border = replace(border, whole=_distance(net, step, whole, np.array([True])))
                    operation = replace(operation, end_error=border.end_error(slack, boxes))
            operations.append(operation)
    return replace(plan, operations=tuple(operations))


def _uncut(step: Step) -> Step:
    """Return an operation whose angles may pass the cut at pi: a whole turn is no distance either."""
    if step.op == "wrap" or angle_result(step.op, step.params) is not None:
        return replace(step, turns=(True,) * len(step.turns))
    return step


@dataclass(frozen=True, slots=True)
class _Distance:
    """By box: how far errors of the operands carry a sample, how near it is to the border, its size.

    `valid` tells where the equations may have a value; `least` is the smallest size of what reaches the end.
    """

    moved: Floats
    margin: Floats
    size: Floats
    valid: Bools
    least: Floats


def _distance(net: ErrorNetwork, step: Step, made: Forward, valid: Bools) -> _Distance:
    """Measure an operation's operands against its border; unbounded where that has no bound."""
    boxes, moved = zip(*(made.operand(operand) for operand in step.operands), strict=True)
    if step.op == "guard":
        return _Distance(moved[1], boxes[1].lo, boxes[1].magnitude, valid, boxes[1].lo)
    if step.op == "lightcone":
        # The smaller one is at the border, whatever the error of one that is positive anyway.
        at = [port for port, operand in enumerate(step.operands) if not _is_positive(net, operand)] or [0, 1]
        low = np.min([boxes[port].mignitude for port in at], axis=0)
        carried = np.max([np.where(boxes[port].mignitude == low, moved[port], 0.0) for port in at], axis=0)
        return _Distance(carried, low, np.maximum(*(box.magnitude for box in boxes)), valid, low)
    if step.op == "vector":
        x, y = boxes[0].absolute(), boxes[1].absolute()
        return _Distance(moved[0] + moved[1], x.lo - y.hi, x.magnitude, valid, x.lo)
    A, B, C = boxes
    if step.params["m"] == 1:
        norm = (A.square() + B.square()).sqrt()
        shift = np.hypot(moved[0], moved[1])
        margin = norm.lo - C.magnitude
    else:
        norm = (B.square() - A.square()).sqrt()  # 0 where there is one solution, and no border
        steep = norm.reciprocal().magnitude
        shift = times(times(A.magnitude, moved[0]) + times(B.magnitude, moved[1]), steep)
        shift = np.where(norm.hi > 0, shift, 0.0)
        margin = np.where(norm.hi > 0, C.mignitude - norm.hi, np.inf)
    return _Distance(moved[2] + shift, margin, np.maximum(norm.hi, C.magnitude), valid, norm.lo)


def _is_positive(net: ErrorNetwork, operand: str | Constant) -> bool:
    """Tell whether what an operand stands for is proven to be positive."""
    if isinstance(operand, Constant):
        return operand.interval.lo > 0
    return operand in net.proven and net.proven[operand].lo > 0


class _Needed(NamedTuple):
    """What counts as the border, beyond it and within, and how many times errors differ."""

    beyond: float
    within: float
    spread: float


def _points(plan: Plan) -> dict[str, Floats]:
    """Return samples: uniform ones, corners, and small ones."""
    workspace = plan.problem.workspace
    usual, small = draw_with_corners(workspace, _SAMPLES), draw_by_size(workspace, _SAMPLES)
    kept = plan.problem.facts.kept(small)
    return {name: np.concatenate([column, small[name][kept]]) for name, column in usual.items()}


@dataclass(frozen=True, slots=True)
class _Border:
    """An operation and the distances from its border: of samples, and of the whole ranges."""

    step: Step
    alone: _Distance
    whole: _Distance

    @property
    def reached(self) -> bool:
        """Tell whether samples may be at the border."""
        return not self.whole.margin[0] > self.whole.moved[0]

    def slack(self, *, scaled: bool) -> Slack:
        """Return what counts as on the border, none if none is needed or none is known.

        `scaled` tells whether it may be relative.
        """
        if not self.reached:
            return EXACT
        moved, size = self.near()
        if not moved.size:
            return EXACT
        absolute = self._needed(moved)
        if scaled and self.sized:
            # Which of the two differs less from sample to sample fits all of them better.
            share = self._needed(moved / size)
            if share.spread < absolute.spread and share.beyond < 1:
                return _rounded_up(share.beyond, self._within(share.within), relative=True)
        return _rounded_up(min(float(self.whole.moved[0]), absolute.beyond), self._within(absolute.within))

    def _needed(self, errors: Floats) -> _Needed:
        """Return what samples need whose errors are these, in one measure or the other."""
        least, most = np.quantile(errors, (_LEAST, _MOST))
        spread = float(most / least)
        if spread > _ALIKE:
            return _Needed(float(least), float(least), spread)
        usual = np.quantile(errors, _MOST if self.clamped else 0.5)
        return _Needed(_ENOUGH * float(most), _ENOUGH * float(usual), spread)

    @property
    def usable(self) -> Bools:
        """Tell which samples say something: those whose errors are known, and not as large as anything."""
        alone = self.alone
        # A condition's operand is small at the border itself.
        size = alone.size if self.sized else self.whole.size
        return alone.valid & (alone.moved > 0) & (alone.moved <= _TELLING * size) & np.isfinite(alone.moved)

    @property
    def sized(self) -> bool:
        """Tell whether the operands have a size at the border."""
        return self.step.op in ("implicit", "vector")

    @property
    def at_border(self) -> Bools:
        """Tell which samples are at the border, as far as errors tell that are small beside the operands."""
        moved = np.minimum(self.alone.moved, _SMALL * self.alone.size)
        return self.usable & (np.abs(self.alone.margin) <= _ENOUGH * moved)

    @property
    def clamped(self) -> bool:
        """Tell whether so many samples are at the border that |C| is made not to exceed R."""
        return bool(_NEAREST * self.at_border.sum() > self.usable.sum())

    def near(self) -> tuple[Floats, Floats]:
        """Return how far samples are carried that are nearest to the border, and their sizes."""
        usable = self.usable
        if not usable.any():
            return self.alone.moved[usable], self.alone.size[usable]
        # Beside a large sample a small one is always near; a condition's operand has no size but its own.
        distance = np.abs(self.alone.margin) / np.where(usable & self.sized, self.alone.size, 1.0)
        last = (int(usable.sum()) - 1) // _NEAREST
        near = usable & (distance <= float(np.partition(distance[usable], last)[last]))
        near |= self.at_border if self.sized else False
        return self.alone.moved[near], self.alone.size[near]

    def _within(self, usual: float) -> float:
        """Return what counts as the end of reach before it: nothing for a root, which is no less right there.

        A known norm is compared with |C|; else the kernel takes for the end what is some times farther.
        """
        if self.step.op != "implicit":
            return 0.0
        return 2 * usual if known_norm(self.step) else usual

    def end_error(self, slack: Slack, operands: Sequence[Boxes]) -> EndError | None:
        """Return what an angle is off at the end of reach, None if no sample comes near or without a bound.

        The residual, errors of the operands included, bounds the change of C that the angle stands for. At
        the end a change of C by d turns it by up to acos(1 - d/R), about sqrt(2 d/R).
        """
        carried = float(self.whole.moved[0])
        near = self.alone.valid & (self.alone.margin <= _NEAR * self.alone.size)
        if not (self.reached and near.any()) or not math.isfinite(carried) or self.step.results[0] is None:
            return None
        step = replace(self.step, slack=slack)
        found = end_residual(step, operands, float(self.whole.size[0]))
        residual, depth = (float(np.max(each)) for each in found)
        total, least = carried + residual, float(self.whole.least[0])
        share = (total + depth) / least if least > 0 else math.inf
        return EndError(_short_above(total), _short_above(math.acos(1 - share)) if share < 1 else None)


def _rounded_up(beyond: float, within: float, *, relative: bool = False) -> Slack:
    """Return a slack of sizes with three digits, none if it is nothing or without bound."""
    if not SIZES[0] < beyond < SIZES[1]:
        return EXACT
    return Slack(_short_above(beyond), _short_above(min(within, beyond)) if within else 0.0, relative)


def _short_above(number: float) -> float:
    scale = 10.0 ** (math.floor(math.log10(number)) - 2)
    return float(f"{math.ceil(number / scale * (1 - 1e-9)) * scale:.3g}")


def _rounded_only(net: ErrorNetwork) -> Mapping[str, NumberFormat]:
    """Return the format of each value that is an input or a constant, signs and extremes apart."""
    found: dict[str, NumberFormat] = {name: net.formats.values[name] for name in net.inputs}
    for step in net.steps:
        if step.op in _MONOTONE and step.results[0] is not None:
            format_ = _common_format(step.operands, found)
            if format_ is not None and (step.formats[0] == format_ or step.exact):
                found[step.results[0]] = format_
    return found


def _common_format(
    operands: Sequence[str | Constant], known: Mapping[str, NumberFormat]
) -> NumberFormat | None:
    """Return the format of which the operands are words, None if there is none."""
    formats = {known.get(operand) for operand in operands if isinstance(operand, str)}
    if len(formats) != 1:
        return None
    (format_,) = formats
    held = all(_holds(format_, o) for o in operands if isinstance(o, Constant)) if format_ else False
    return format_ if held else None


def _holds(format_: NumberFormat, constant: Constant) -> bool:
    """Tell whether a constant is rounded as the words of a format are."""
    number = constant.interval.lo
    if not isinstance(format_, FixedPoint):
        return True  # the same rounding makes every constant
    exact = constant.error == 0 and constant.interval.hi == number
    return exact and float(format_.decode(format_.encode(np.array([number])))[0]) == number


def _monotone(step: Step, rounded: Mapping[str, NumberFormat]) -> bool:
    """Tell whether an operation compares words of one format that nothing but rounding has made."""
    operands: Sequence[str | Constant] = step.operands
    if step.op == "guard":
        operands = operands[1:]
    elif step.op == "vector":
        operands = operands[:2]
    elif step.op == "implicit":
        if not known_norm(step):
            return False
        operands = [o for o in operands if not (isinstance(o, Constant) and o.interval.magnitude == 0)]
    return _common_format(operands, rounded) is not None
