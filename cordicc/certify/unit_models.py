"""What the CORDIC operations do to intervals and errors: values, partial derivatives, own error.

All quantities hold for operands anywhere in given boxes, see `operator_models`.

Derivatives. Circular vectoring, N the norm: N has (x, y)/N, the angle (-y, x)/N^2; hyperbolic (x, -y)/N and
(-y, x)/N^2; the quotient y/x has (-q, 1)/x. sqrt(u v) has (v, u)/(2 root), ln(u/v)/2 has (1/u, -1/v)/2. For
B cos t + A sin t = C with the rest w = A cos t - B sin t, d t = (dC - cos t dB - sin t dA)/w and d|w| =
(A dA + B dB - C dC)/|w|; hyperbolic: w = A cosh t + B sinh t, d t = (dC - cosh t dB - sinh t dA)/w and d|w| =
(A dA - B dB + C dC)/|w|.

Own error of an implicit angle. The unit proves that its angle leaves a residual of at most p, on the right
branch. With D its distance from t, the residual is at least |w| D - R D^2/2 (m = -1: |w| sinh D - |C|
(cosh D - 1), and cosh D - 1 <= 0.55 D^2 for D <= 1), so D <= (p/|w|) 2/(1 + sqrt(1 - 2 R p/w^2)), if
w^2 >= 4 R p, which also keeps the other branch out of reach: there the rest is -|w| to within |w|/2, and the
unit's is no less than -p. Beside the end of reach it is another one, of the angle of the end itself,
see `_beside_end`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from cordicc.arith.unit.cau import Cau
from cordicc.arith.unit.implicit_bounds import ImplicitUnitBound, end_rest, implicit_bound
from cordicc.arith.unit.unit_bounds import lightcone_bound, rotation_bound, vectoring_bound
from cordicc.base.arrays import Bools, Floats
from cordicc.certify.boxes import (
    PI_UP,
    TAU_UP,
    Boxes,
    arc_cosine,
    cosh,
    cosine,
    crosses_cut,
    direction,
    hypot,
    point,
    sine,
    sinh,
    up,
)
from cordicc.certify.error_network import Step, known_norm

_UNDERFLOW = 2.0**-500
"""Results of a unit below 2^-511 are 0."""

_ADDEND = 2.0**-48
"""Relative error of the addend in linear modes, see `rotation_bound`."""

_EVERY_ANGLE = Boxes(np.array(-PI_UP), np.array(PI_UP))

_rotation = cache(rotation_bound)
_vectoring = cache(vectoring_bound)
_lightcone = cache(lightcone_bound)
_implicit = cache(implicit_bound)


@dataclass(frozen=True, slots=True)
class Local:
    """One operation on boxes: by result its values, derivatives by operand, own error.

    `joint` bounds the own error of both results as one vector, besides `own`.
    """

    values: tuple[Boxes, ...]
    partials: tuple[tuple[Boxes, ...], ...]
    own: tuple[Floats, ...]
    joint: Floats | None = None


def _place(unit: Cau, *operands: Boxes) -> Floats:
    """Return the largest last place of a block."""
    largest = operands[0].magnitude
    for operand in operands[1:]:
        largest = np.maximum(largest, operand.magnitude)
    return np.asarray(np.ldexp(1.0, np.frexp(largest)[1] - unit.fraction_bits), dtype=np.float64)


def rotate(step: Step, w: Sequence[Boxes]) -> Local:
    """Return what rotation does: (x C - m y S, y C + x S)."""
    x, y, z = w
    unit, m = step.cau, step.params["m"]
    assert unit is not None
    bound = _rotation(unit, m, step.quarters)
    zero, one = point(0.0, len(x.lo)), point(1.0, len(x.lo))
    if m == 0:
        product = x * z
        own = up(bound.error(product.magnitude, _place(unit, x)) + _ADDEND * y.magnitude + _UNDERFLOW)
        return Local((x, y + product), ((one, zero, zero), (z, one, x)), (zero.lo, own))
    c, s = (cosine(z), sine(z)) if m == 1 else (cosh(z), sinh(z))
    first, second = x * c - (y * s).scaled(float(m)), y * c + x * s
    if m == 1:
        radius = hypot(x, y).hi
        first, second = first.within(radius), second.within(radius)
        place = np.maximum(
            _place(unit, x, y), math.ldexp(1.0, step.least + unit.operand_bits - unit.fraction_bits)
        )
        joint = up(bound.error(radius, place) + _UNDERFLOW)
        return Local((first, second), ((c, -s, -second), (s, c, first)), (zero.lo, zero.lo), joint)
    # On the light cone (x + y) grows by e^z and (x - y) by e^-z: tight where one of them is 0.
    same = step.operands[0] == step.operands[1]
    growth, difference = z.monotone(np.exp), zero if same else x - y
    grown, shrunk = (x + y) * growth, difference * (-z).monotone(np.exp)
    first, second = first.meet((grown + shrunk).scaled(0.5)), second.meet((grown - shrunk).scaled(0.5))
    size = np.maximum(first.magnitude, second.magnitude)
    own = up(bound.error(size, _place(unit, x, y)) + _UNDERFLOW)
    if same:
        c, s = growth, zero  # what both ways from x to a result add up to
    return Local((first, second), ((c, s, second), (s, c, first)), (own, own))


def vector(step: Step, w: Sequence[Boxes], square: Boxes | None) -> Local:
    """Return what vectoring does: the norm, and z plus or minus the angle."""
    x, y, z = w
    unit, m, sign = step.cau, step.params["m"], float(step.params["sign"])
    assert unit is not None
    bound = _vectoring(unit, m)
    zero, one = point(0.0, len(x.lo)), point(1.0, len(x.lo))
    if m == 0:
        assert square is not None
        inverse = _inverse(x, square)
        quotient = y * inverse
        own = up(bound.angle * quotient.magnitude + _ADDEND * z.magnitude + _UNDERFLOW)
        by_x, by_y = -(quotient * inverse).scaled(sign), inverse.scaled(sign)
        return Local((x, z + quotient.scaled(sign)), ((one, zero, zero), (by_x, by_y, one)), (zero.lo, own))
    assert square is not None
    norm = square.sqrt()
    inverse = norm.reciprocal()
    inverse_square = square.reciprocal()
    across = (-y * inverse_square).within(inverse.hi) if m == 1 else -y * inverse_square
    along = (x * inverse_square).within(inverse.hi) if m == 1 else x * inverse_square
    of_norm = ((x * inverse), (y * inverse).scaled(float(m)))
    if m == 1:
        of_norm = (of_norm[0].within(1.0), of_norm[1].within(1.0))
        angle = direction(y, x)
    else:
        ratio = y / x
        clipped = Boxes(np.clip(ratio.lo, -1.0, 1.0), np.clip(ratio.hi, -1.0, 1.0))
        with np.errstate(divide="ignore"):
            angle = clipped.monotone(np.arctanh)
    own_norm = up(bound.norm.error(norm.hi, _place(unit, x, y)) + _UNDERFLOW)
    limit = math.ldexp(1.0, 50 - unit.angle_bits) - 2 * TAU_UP
    own_angle = np.where(z.magnitude < limit, bound.angle, math.inf)
    if m == 1 and not step.turns[1]:
        cut = crosses_cut(y, x)
        own_angle, angle = np.where(cut, own_angle + TAU_UP, own_angle), angle.where(~cut, _EVERY_ANGLE)
    partials = ((*of_norm, zero), (across.scaled(sign), along.scaled(sign), one))
    return Local((norm, z + angle.scaled(sign)), partials, (own_norm, up(own_angle)))


def _inverse(x: Boxes, square: Boxes) -> Boxes:
    """Enclose 1/x, of which the square is known to be positive."""
    made = x.reciprocal()
    return made.within(square.sqrt().reciprocal().hi)


def lightcone(step: Step, w: Sequence[Boxes], square: Boxes | None) -> Local:
    """Return what light-cone vectoring does: the root of u v and half the logarithm of u/v."""
    u, v = w
    assert step.cau is not None
    assert square is not None
    bound = _lightcone(step.cau)
    root = square.sqrt()
    inverse = root.reciprocal().scaled(0.5)
    own = up(bound.norm.error(root.hi, _place(step.cau, u, v)) + _UNDERFLOW)
    ratio = u / v
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = Boxes(np.maximum(ratio.lo, 0.0), ratio.hi).monotone(np.log).scaled(0.5)
    halves = (u.reciprocal().scaled(0.5), -v.reciprocal().scaled(0.5))
    return Local((root, angle), ((v * inverse, u * inverse), halves), (own, np.full_like(own, bound.angle)))


def implicit(step: Step, w: Sequence[Boxes], square: Boxes | None) -> Local:
    """Return what the implicit modes do: t of B cos t + A sin t = C (m = -1: cosh, sinh), and the rest."""
    A, B, C = w
    unit, m = step.cau, step.params["m"]
    assert unit is not None
    assert square is not None
    bound = _implicit(unit, m)
    rest = square.sqrt()
    inverse = rest.reciprocal()
    place = _place(unit, A, B, C)
    if m == 1:
        reach, turn = hypot(A, B), 1.0
        cut = crosses_cut(A, B) & (not step.turns[0])
        angle, c, s = _circular(step, w, rest, reach, cut)
        side = -inverse if step.params["branch"] == "+" else inverse
        by_rest = (A * inverse, B * inverse, -C * inverse)
        size = reach.hi
    else:
        angle, side = _hyperbolic(step, w, rest, inverse)
        c, s = cosh(angle), sinh(angle)
        by_rest = (A * inverse, -B * inverse, C * inverse)
        size, turn = np.maximum(C.magnitude, rest.hi), 1.1
    by_angle = (-(s * side), -(c * side), side)
    residual = bound.residual.error(size, place)
    share = 2 * turn * residual * size / np.where(rest.lo > 0, rest.lo, 1.0) ** 2
    depth = _depth(step, bound, place)
    far = (share <= 0.5) & (rest.lo > end_rest(size, depth))
    off = residual * inverse.hi * 2 / (1 + np.sqrt(np.where(far, 1 - share, 1.0)))
    own_angle = np.where(far, up(off), math.inf)
    if m == 1:
        # Beside the end of reach derivatives grow without bound, but the angle is all but that of the end.
        off, (end_A, end_B) = _beside_end(w, bound, reach, np.maximum(residual, depth), place)
        own_angle = np.where(far, own_angle, off)
        nothing = point(0.0, len(A.lo))
        by_A, by_B, by_C = by_angle
        by_angle = (by_A.where(far, end_A), by_B.where(far, end_B), by_C.where(far, nothing))
        own_angle = np.where(cut, own_angle + TAU_UP, own_angle)
    own_rest = np.asarray(bound.rest(size, C.magnitude, rest.lo, place, depth))
    return Local((angle, rest), (by_angle, by_rest), (own_angle, up(own_rest)))


def _beside_end(
    w: Sequence[Boxes], bound: ImplicitUnitBound, reach: Boxes, residual: Floats, place: Floats
) -> tuple[Floats, tuple[Boxes, Boxes]]:
    """Return what an angle is off as that of the end of reach, and the derivatives of that by A and B.

    t is psi = atan2(A, B) or psi + pi, and acos(|C|/R) more or less, exact or computed. The computed one
    leaves a residual, or is that of the end where |C| is no farther from it, and may be past the end by a
    last angle and the error of x.
    """
    A, B, C = w
    certain = (C.lo > 0) | (C.hi < 0)
    inverse = (A.square() + B.square()).reciprocal()
    least = np.where(reach.lo > 0, reach.lo, 1.0)
    past = bound.residual.relative + bound.end.along * place / least * (math.pi / 2)
    share = np.maximum(C.mignitude - residual, 0.0) / np.maximum(reach.hi, least)
    off = up(arc_cosine(Boxes(share, share)).hi + past)
    return np.where(certain & (reach.lo > 0), off, math.inf), (B * inverse, -(A * inverse))


def end_residual(step: Step, w: Sequence[Boxes], size: float) -> tuple[Floats, Floats]:
    """Return the residual of an implicit angle, and how near the end of reach the unit delivers the end.

    Both in the unit of the operands, whose norm is at most `size`.
    """
    assert step.cau is not None
    bound, place = _implicit(step.cau, step.params["m"]), _place(step.cau, *w)
    return bound.residual.error(np.full_like(place, size), place), _depth(step, bound, place)


def _depth(step: Step, bound: ImplicitUnitBound, place: Floats) -> Floats:
    """Return how near |C| is at most to the end of reach where the unit delivers the end."""
    within = np.full_like(place, step.slack.within)
    if step.slack.relative:
        within = within * bound.end.largest * place
    return bound.depth(place, within, known_norm(step))


def _circular(
    step: Step, w: Sequence[Boxes], rest: Boxes, reach: Boxes, cut: Bools
) -> tuple[Boxes, Boxes, Boxes]:
    """Enclose t, cos t and sin t: atan2(A, B) +- acos(C/R), (B C -+ A w)/R^2, (A C +- B w)/R^2."""
    A, B, C = w
    plus = step.params["branch"] == "+"
    offset = arc_cosine(C / reach)
    centre = direction(A, B).where(~cut, _EVERY_ANGLE)
    angle = centre + offset if plus else centre - offset
    inverse = (A.square() + B.square()).reciprocal()
    side = rest if plus else -rest
    c, s = (B * C - A * side) * inverse, (A * C + B * side) * inverse
    return angle, c.meet(cosine(angle)), s.meet(sine(angle))


def _hyperbolic(step: Step, w: Sequence[Boxes], rest: Boxes, inverse: Boxes) -> tuple[Boxes, Boxes]:
    """Enclose t and 1/x(t), x(t) = A cosh t + B sinh t being the rest with its sign.

    One solution (|A| > |B|): x has the sign of A. Two: of B, and branch "-" that of -B.
    E = e^t = (C + x)/(B + A) = (B - A)/(C - x).
    """
    A, B, C = w
    branch = step.params["branch"]
    toward = {"none": A, "+": B, "-": -B}[branch]  # has the sign of x where |B| > |A|
    positive = (A.lo > B.magnitude) | (toward.lo > A.magnitude) | ((A.lo > 0) & (toward.lo > 0))
    negative = (A.hi < -B.magnitude) | (toward.hi < -A.magnitude) | ((A.hi < 0) & (toward.hi < 0))
    both = rest.join(-rest)
    x = rest.where(positive, (-rest).where(negative, both))
    side = inverse.where(positive, (-inverse).where(negative, inverse.join(-inverse)))
    first, second = (C + x) / (B + A), (B - A) / (C - x)
    exponential = Boxes(np.maximum(first.lo, second.lo), np.minimum(first.hi, second.hi))
    exponential = Boxes(np.maximum(exponential.lo, 0.0), np.maximum(exponential.hi, 0.0))
    with np.errstate(divide="ignore"):
        return exponential.monotone(np.log), side
