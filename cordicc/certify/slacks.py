"""The slack of operations with a border: how far errors of the operands may carry a sample across it.

Where the equations are at the border, |C| = R or a root of 0, the words are beside it, and beyond it as often
as not. Their distance is at most that of the operands' errors, which the forward sweep bounds: over the whole
ranges for every sample, and for each sample alone. The former is enough for all, but where ranges are wide it
may be far from what any sample has; so the slack is at most `_ENOUGH` times what is proven of nine in ten of the
default samples next to the border.

Beyond the border the slack takes nothing away: what is there has no other value. Before the end of reach it
would, so what counts as the end there is no more than what half of the samples need.

Rounding is monotone. So words of one format that nothing but rounding has made, of inputs and exact constants,
are on the right side of one another, and an operation on such operands has no slack.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.formats import NumberFormat
from cordicc.arith.numbers.slack import EXACT, SIZES, Slack
from cordicc.base.arrays import Bools, Floats
from cordicc.certify.boxes import Boxes, times
from cordicc.certify.error_network import Constant, ErrorNetwork, Step, known_norm, network
from cordicc.certify.sweep import Forward, forward
from cordicc.ir.ops import has_border
from cordicc.ir.sampling import draw_with_corners
from cordicc.plan.model import Plan

_SAMPLES = 2_000
_NEAREST = 20
"""The share of samples next to a border is one in so many."""

_MOST = 0.9
"""The share of these whose operands have errors within what is taken."""

_ENOUGH = 2.0

_PASSED_ON = ("neg", "abs", "min", "max", "flip", "select", "guard", "sign")
"""Operations that make no other number than an operand, its negative, or its sign."""


def with_slacks(plan: Plan) -> Plan:
    """Return a plan that holds its unit program, with the slack of each operation that has one."""
    if not any(has_border(operation.op, operation.params) for operation in plan.operations):
        return plan
    net = network(plan)
    if not net.inputs:
        return plan
    points = draw_with_corners(plan.problem.workspace, _SAMPLES)
    alone = forward(net, net.steps, {name: Boxes(points[name], points[name]) for name in net.inputs}, {})
    ranges = {name: Boxes(np.array([i.lo]), np.array([i.hi])) for name, i in net.inputs.items()}
    whole = forward(net, net.steps, ranges, {})
    rounded = _rounded_only(net)
    # Words of fixed point err by as much whatever their size.
    fixed_point = any(isinstance(format_, FixedPoint) for format_ in net.formats.values.values())
    operations = []
    for operation, step in zip(plan.operations, net.steps, strict=True):
        assert operation.id == step.id
        if has_border(step.op, step.params) and not _monotone(step, rounded):
            valid = ~alone.empty(net.before(step))
            scaled = step.op in ("implicit", "vector") and not fixed_point
            slack = _slack(_distance(step, alone), valid, _distance(step, whole), scaled=scaled)
            operation = replace(operation, slack=replace(slack, within=_within(step, slack)))
        operations.append(operation)
    return replace(plan, operations=tuple(operations))


@dataclass(frozen=True, slots=True)
class _Distance:
    """By box: how far errors of the operands carry a sample, how near it is to the border, its size."""

    moved: Floats
    margin: Floats
    size: Floats


def _distance(step: Step, made: Forward) -> _Distance:
    """Measure an operation's operands against its border; unbounded where that has no bound."""
    boxes, moved = zip(*(made.operand(operand) for operand in step.operands), strict=True)
    if step.op == "guard":
        return _Distance(moved[1], boxes[1].lo, boxes[1].magnitude)
    if step.op == "lightcone":
        low = np.minimum(boxes[0].mignitude, boxes[1].mignitude)
        return _Distance(np.maximum(*moved), low, np.maximum(boxes[0].magnitude, boxes[1].magnitude))
    if step.op == "vector":
        x, y = boxes[0].absolute(), boxes[1].absolute()
        return _Distance(moved[0] + moved[1], x.lo - y.hi, x.magnitude)
    A, B, C = boxes
    if step.params["m"] == 1:
        norm = (A.square() + B.square()).sqrt()
        shift = np.hypot(moved[0], moved[1])
        margin = norm.lo - C.magnitude
    else:
        norm = (B.square() - A.square()).sqrt()  # 0 where there is one solution, and no border
        steep = norm.reciprocal().magnitude
        shift = times(A.magnitude * moved[0] + B.magnitude * moved[1], steep)
        shift = np.where(norm.hi > 0, shift, 0.0)
        margin = np.where(norm.hi > 0, C.mignitude - norm.hi, np.inf)
    return _Distance(moved[2] + shift, margin, np.maximum(norm.hi, C.magnitude))


def _slack(alone: _Distance, valid: Bools, whole: _Distance, *, scaled: bool) -> Slack:
    """Return what counts as on the border, none if none is needed or none is known.

    Args:
        alone: of samples alone.
        valid: which of them the equations may have a value for.
        whole: of the ranges.
        scaled: whether it may be relative.
    """
    if whole.margin[0] > whole.moved[0]:
        return EXACT
    usable = valid & np.isfinite(alone.moved) & (alone.moved > 0) & (alone.size > 0)
    if not usable.any():
        return _rounded_up(float(whole.moved[0]), float(whole.moved[0]))
    moved, size, margin = (column[usable] for column in (alone.moved, alone.size, alone.margin))
    near = _next_to(margin, moved)
    large, usual = np.quantile(moved[near], (_MOST, 0.5)) * _ENOUGH
    large_share, usual_share = np.quantile(moved[near] / size[near], (_MOST, 0.5)) * _ENOUGH
    # Which of the two differs less from sample to sample fits all of them better.
    if scaled and large_share * usual < large * usual_share and large_share < 1:
        return _rounded_up(large_share, usual_share, relative=True)
    most = min(float(whole.moved[0]), large)
    return _rounded_up(most, min(most, usual))


def _within(step: Step, slack: Slack) -> float:
    """Return what counts as the end of reach before it: nothing for a root, which is no less right beside 0.

    A known norm is compared with |C|; else the kernel takes for the end what is some times farther.
    """
    if step.op != "implicit":
        return 0.0
    return min(slack.beyond, 2 * slack.within) if known_norm(step) else slack.within


def _next_to(margin: Floats, moved: Floats) -> Bools:
    """Tell which samples are at the border, as far as errors tell, or are among the nearest to it."""
    distance = np.abs(margin)
    last = (len(distance) - 1) // _NEAREST
    return (distance <= np.partition(distance, last)[last]) | (distance <= _ENOUGH * moved)


def _rounded_up(beyond: float, within: float, *, relative: bool = False) -> Slack:
    """Return a slack of sizes with three digits, none if it is nothing or without bound."""
    if not SIZES[0] < beyond < SIZES[1]:
        return EXACT
    return Slack(_short_above(beyond), _short_above(max(within, SIZES[0])), relative)


def _short_above(number: float) -> float:
    scale = 10.0 ** (math.floor(math.log10(number)) - 2)
    return float(f"{math.ceil(number / scale * (1 - 1e-9)) * scale:.3g}")


def _rounded_only(net: ErrorNetwork) -> Mapping[str, NumberFormat]:
    """Return the format of each value that is an input or a constant of one format, but for signs and choices."""
    found: dict[str, NumberFormat] = {name: net.formats.values[name] for name in net.inputs}
    for step in net.steps:
        if step.op in _PASSED_ON and step.results[0] is not None:
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
