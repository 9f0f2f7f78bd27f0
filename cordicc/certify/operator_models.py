"""What each operation does to intervals and errors: values, partial derivatives, its own error.

An operation computes f(operands) + e on the words that it gets, |e| <= its own error. All quantities hold for
operands anywhere in given boxes, which hold the exact operands, the computed ones, and what lies on the way
from the former to the latter while every error grows from 0 to its full size.

Choices. Where a sign may differ between exact and computed operands, the exact choice is followed and the
difference of the alternatives is an own error. So is the whole turn where an angle may pass the cut at pi
and that matters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from cordicc.base.arrays import Bools, Floats
from cordicc.certify import unit_models
from cordicc.certify.boxes import PI_UP, TAU_UP, Boxes, point, up
from cordicc.certify.error_network import Step, rounding
from cordicc.certify.unit_models import Local
from cordicc.ir.ops import angle_result

_NEAR_PI = 2.0**-7
"""More than a word, or any error of an angle for which a bound is of use."""

_MOST_TURNS = 2.0**40
"""More turns than an angle has that is known to a part of one."""

Model = Callable[[Step, Sequence[Boxes], "Boxes | None", Sequence[Floats]], Local]


def margin_square(step: Step, w: Sequence[Boxes]) -> Boxes | None:
    """Enclose the square of an operation's margin, which is 0 where it is singular; None if it never is."""
    match step.op:
        case "vector" if step.params["m"] == 0:
            return w[0].square()
        case "vector" if step.params["m"] == 1:
            return w[0].square() + w[1].square()
        case "vector":
            return w[0].square() - w[1].square()
        case "lightcone":
            return w[0] * w[1]
        case "implicit":
            A, B, C = (operand.square() for operand in w)
            return A + B - C if step.params["m"] == 1 else A - B + C
        case "flip" | "sign" | "select":
            return w[CHOOSER[step.op]].square() if _chooses(step) else None
    return None


def margin_slopes(step: Step, w: Sequence[Boxes]) -> tuple[Boxes, ...]:
    """Enclose the derivatives of the margin's square by the operands of a unit operation."""
    if step.op == "lightcone":
        return w[1], w[0]
    m = step.params["m"]
    factors = (2.0, 2.0 * m, -2.0 * m) if step.op == "implicit" else (2.0, 2.0 * m, 0.0)
    return tuple(operand.scaled(factor) for operand, factor in zip(w, factors, strict=True))


CHOOSER = {"flip": 1, "sign": 0, "select": 0}
"""The operand whose sign decides."""


def _chooses(step: Step) -> bool:
    return not (step.op == "flip" and step.operands[0] == step.operands[1])


def local(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    """Return what an operation does.

    Args:
        step: the operation.
        w: boxes of its operands.
        square: of the margin's square.
        moved: how far each operand moves at most on the way from exact to computed.
    """
    made = MODELS[step.op](step, w, square, moved)
    count = np.shape(w[0].lo)
    own = []
    for result, error in enumerate(made.own):
        format_ = step.formats[result]
        if format_ is None:
            own.append(np.zeros(count))
            continue
        # What may be a whole turn off where it is enclosed is rounded as the number that it is.
        least = step.sizes[result] + _NEAR_PI if step.sizes[result] else 0.0
        size = np.maximum(made.values[result].magnitude, least)
        passed_on = step.cau is None or step.params.get("m") == 0
        if not (step.exact and passed_on and result == 0):
            error = up(error + rounding(format_, size, _beside_pi(step, result, made.values[result])))
        own.append(error)
    return Local(made.values, made.partials, tuple(own), made.joint)


def _beside_pi(step: Step, result: int, value: Boxes) -> Bools:
    """Tell where an angle may be so near to pi that it is not rounded to the nearest word."""
    if result != angle_result(step.op, step.params) and step.op != "wrap":
        return np.array(False)
    first = (value.lo - _NEAR_PI) / math.tau - 0.5
    return np.asarray(np.ceil(first) <= (value.hi + _NEAR_PI) / math.tau - 0.5)


def _zero(w: Sequence[Boxes]) -> Floats:
    return np.zeros(np.shape(w[0].lo))


def _one(w: Sequence[Boxes], value: float = 1.0) -> Boxes:
    return point(value, len(w[0].lo))


def _plain(value: Boxes, partials: Sequence[Boxes], own: Floats) -> Local:
    return Local((value,), (tuple(partials),), (own,))


def _add(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    one = _one(w)
    if step.op == "add":
        return _plain(w[0] + w[1], (one, one), _zero(w))
    return _plain(w[0] - w[1], (one, -one), _zero(w))


def _mul(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    value = w[0].square() if step.operands[0] == step.operands[1] else w[0] * w[1]
    return _plain(value, (w[1], w[0]), _zero(w))


def _cmul(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    assert step.factor is not None
    factor = _one(w, step.factor.interval.lo).join(_one(w, step.factor.interval.hi))
    return _plain(w[0] * factor, (factor,), up(w[0].magnitude * step.factor.error))


def _shift(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    factor = math.ldexp(1.0, int(step.params["exponent"]))
    return _plain(w[0].scaled(factor), (_one(w, factor),), _zero(w))


def _neg(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    return _plain(-w[0], (_one(w, -1.0),), _zero(w))


def _signs(s: Boxes) -> Boxes:
    """Enclose 1 where s >= 0 and -1 where s < 0."""
    return Boxes(np.where(s.lo >= 0, 1.0, -1.0), np.where(s.hi < 0, -1.0, 1.0))


def _abs(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    return _plain(w[0].absolute(), (_signs(w[0]),), _zero(w))


def _undecided(s: Boxes, square: Boxes | None, moved: Floats) -> Bools:
    """Tell where the sign of s may change on the way from exact to computed."""
    certain = (s.lo >= 0) | (s.hi < 0)
    if square is not None:
        certain |= square.lo > 0
    return ~certain & (moved > 0)


def _sign(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    s = w[0]
    low = np.where(s.lo > 0, 1.0, np.where(s.lo == 0, 0.0, -1.0))
    high = np.where(s.hi < 0, -1.0, np.where(s.hi == 0, 0.0, 1.0))
    certain = (s.lo > 0) | (s.hi < 0) | (moved[0] == 0)
    if square is not None:
        certain |= square.lo > 0
    return _plain(Boxes(low, high), (_one(w, 0.0),), np.where(certain, 0.0, 2.0))


def _flip(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    if not _chooses(step):
        return _plain(w[0].absolute(), (_signs(w[0]), _one(w, 0.0)), _zero(w))
    signs = _signs(w[1])
    jump = np.where(_undecided(w[1], square, moved[1]), 2 * w[0].magnitude, 0.0)
    return _plain(w[0] * signs, (signs, _one(w, 0.0)), up(jump))


def _select(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    s, a, b = w
    zero, one = _one(w, 0.0), _one(w)
    first, second = s.lo >= 0, s.hi < 0
    of_a = one.where(first, zero.where(second, zero.join(one)))
    of_b = zero.where(first, one.where(second, zero.join(one)))
    value = a.where(first, b.where(second, a.join(b)))
    jump = np.where(_undecided(s, square, moved[0]), (a - b).magnitude, 0.0)
    return _plain(value, (zero, of_a, of_b), up(jump))


def _extreme(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    smaller = step.op == "min"
    pick = np.minimum if smaller else np.maximum
    zero, one = _one(w, 0.0), _one(w)
    a, b = w if smaller else (w[1], w[0])
    first, second = a.hi <= b.lo, b.hi <= a.lo  # the first operand is taken, the second is
    either = zero.join(one)
    of_a = one.where(first, zero.where(second, either))
    of_b = zero.where(first, one.where(second, either))
    value = Boxes(pick(w[0].lo, w[1].lo), pick(w[0].hi, w[1].hi))
    return _plain(value, (of_a, of_b), _zero(w))


def _guard(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    return _plain(w[0], (_one(w), _one(w, 0.0)), _zero(w))


def _wrap(step: Step, w: Sequence[Boxes], square: Boxes | None, moved: Sequence[Floats]) -> Local:
    # 2 pi has 28 bits more than the angle (fixed point), or at least 2^-50 rad is lost.
    own = up((w[0].magnitude + 2 * TAU_UP) * (step.spacing * 2.0**-28) + 2.0**-50)
    # A box that lies within a turn moves by the same number of turns as a whole.
    middle = np.nan_to_num((w[0].lo + w[0].hi) / 2)  # 0 of what is unbounded
    turns = np.asarray(np.round(np.clip(middle / math.tau, -_MOST_TURNS, _MOST_TURNS)), dtype=np.float64)
    value = w[0] - Boxes(turns, turns) * Boxes(np.array(math.tau), np.array(TAU_UP))
    if step.turns[0]:
        return _plain(value, (_one(w),), own)
    inside = (value.lo > -math.pi) & (value.hi < math.pi)
    every = Boxes(-_one(w, PI_UP).lo, _one(w, PI_UP).lo)
    return _plain(value.where(inside, every), (_one(w),), np.where(inside, own, own + TAU_UP))


MODELS: dict[str, Model] = {
    "add": _add,
    "sub": _add,
    "mul": _mul,
    "cmul": _cmul,
    "shift": _shift,
    "neg": _neg,
    "abs": _abs,
    "sign": _sign,
    "min": _extreme,
    "max": _extreme,
    "flip": _flip,
    "select": _select,
    "guard": _guard,
    "wrap": _wrap,
    "rotate": lambda step, w, square, moved: unit_models.rotate(step, w),
    "vector": lambda step, w, square, moved: unit_models.vector(step, w, square),
    "lightcone": lambda step, w, square, moved: unit_models.lightcone(step, w, square),
    "implicit": lambda step, w, square, moved: unit_models.implicit(step, w, square),
}
