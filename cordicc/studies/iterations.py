"""Iterations in high precision, row by row, to be read and compared with published tables.

Nothing is rounded but the last of `PRECISION_BITS` bits, so every printed decimal is the method's own.
The rules are those of the kernels: Walther 1971 (standard), Krieger and Hosticka 1996, eqs. 13 to 16
(root-free, scaled within the iteration) and eq. 9 (their implicit rule, kept for study; it does not
converge for every input), and the implicit rules that scale the target instead of the vector.
sgn(0) = +1 throughout.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from mpmath import MPContext

from cordicc.arith.kernels.shift_sequences import Sequence, exact_angle

PRECISION_BITS = 256

mp = MPContext()
"""The arithmetic of this module: real numbers of 256 bits."""
mp.prec = PRECISION_BITS


@dataclass(frozen=True, slots=True)
class State:
    """A vector, an angle in radians (a ratio for m = 0), and the target of an implicit equation or None.

    The numbers are those of `mp`.
    """

    x: Any
    y: Any
    z: Any
    target: Any = None


@dataclass(frozen=True, slots=True)
class IterationRow:
    """The state after iteration `index`, counted from 1; `eta` is None without scaling."""

    index: int
    shift: int
    eta: int | None
    state: State


@dataclass(frozen=True, slots=True)
class IterationRun:
    """The state from which the iterations start, what was done to reach it, and the iterations.

    `mirrored`: the rule has run on -x and -z, which the states give as x and z.
    """

    start: State
    rows: tuple[IterationRow, ...]
    preparation: str = ""
    negated: bool = False
    mirrored: bool = False

    @property
    def end(self) -> State:
        """The state after the last iteration."""
        return self.rows[-1].state if self.rows else self.start


Rule = Callable[[State], int]
"""Chooses the direction of the next micro-rotation: +1 is counter-clockwise."""


def halves_angles(sequence: Sequence) -> bool:
    """Return whether z counts atan 2^-S although the vector turns by twice that: so the paper prints it."""
    return bool(sequence.eta)


def counted_angle(sequence: Sequence, shift: int) -> Any:
    """Return what a micro-rotation adds to or takes from z."""
    return mp.mpf(exact_angle(sequence.m, shift, sequence.root_free and not halves_angles(sequence)))


def _sign(value: Any) -> int:
    return -1 if value < 0 else 1


def rotate(sequence: Sequence, start: State) -> IterationRun:
    """Drive z to 0."""
    return IterationRun(start, _iterate(sequence, start, lambda s: _sign(s.z), counts=-1))


def vector(sequence: Sequence, start: State) -> IterationRun:
    """Drive y to 0; z gains atan(y/x), the ratio or the hyperbolic angle."""
    return IterationRun(start, _iterate(sequence, start, lambda s: -_sign(s.x) * _sign(s.y), counts=-1))


def implicit_by_eq9(sequence: Sequence, start: State) -> IterationRun:
    """Drive y to the target by the paper's rule; z gains the angle turned."""
    return IterationRun(
        start, _iterate(sequence, start, lambda s: -_sign(s.y - s.target) * _sign(s.x), counts=1)
    )


def implicit(sequence: Sequence, start: State, branch: str) -> IterationRun:
    """Drive y to the target with the target scaled, to the wanted one of two solutions.

    The rule ends at x >= 0; the other solution is the mirror image, with -x for x and -z for z.  Rows are
    mirrored back, so they show the given vector turning.
    """
    natural = "-" if sequence.m > 0 or start.y < 0 else "+"
    mirrored = branch != natural and (sequence.m > 0 or abs(start.y) > abs(start.x))
    run = _to_the_right(sequence, _mirror(start) if mirrored else start, mirrored)
    if not mirrored:
        return run
    rows = tuple(replace(row, state=_mirror(row.state)) for row in run.rows)
    return replace(run, start=_mirror(run.start), rows=rows, mirrored=True)


def _mirror(state: State) -> State:
    return replace(state, x=-state.x, z=-state.z)


def _to_the_right(sequence: Sequence, start: State, mirrored: bool) -> IterationRun:
    """Prepare the start so that the iterations reach the solution with x >= 0, and run them."""
    prepare = _prepare_circular if sequence.m > 0 else _prepare_hyperbolic
    run = prepare(sequence, start, mirrored)
    back = -1 if sequence.m > 0 else 1

    def towards(s: State) -> int:
        return back * _sign(s.y) if s.x < 0 else _sign(s.target - s.y)

    return replace(run, rows=_iterate(sequence, run.start, towards, counts=1))


def _prepare_circular(sequence: Sequence, start: State, mirrored: bool) -> IterationRun:
    """Turn the start to x >= 0 by half a turn; for single rotations to the target's side of y = 0."""
    s, turned = start, mp.mpf(0)
    # A mirrored x of -0 belongs to atan2(0, B) = +pi, which mirrors to the left side.
    if s.x < 0 or (mirrored and s.x == 0 and s.y < 0):
        s, turned = replace(s, x=-s.x, y=-s.y), -mp.pi
    if not sequence.root_free and (s.target >= 0) != (s.y >= 0):
        up = 1 if s.target >= 0 else -1
        s, turned = replace(s, x=-up * s.y, y=up * s.x), turned + up * mp.pi / 2
    if turned == 0:
        return IterationRun(s, ())
    degrees = int(mp.nint((-turned if mirrored else turned) * 180 / mp.pi))
    return IterationRun(replace(s, z=s.z + turned), (), f"the start turned by {degrees:+d} degrees")


def _prepare_hyperbolic(sequence: Sequence, start: State, mirrored: bool) -> IterationRun:
    if mirrored or abs(start.y) > abs(start.x) or start.x >= 0:
        return IterationRun(start, ())
    negative = State(-start.x, -start.y, start.z, -start.target)
    return IterationRun(negative, (), "the equation negated, to have x >= 0", negated=True)


def _iterate(sequence: Sequence, start: State, rule: Rule, counts: int) -> tuple[IterationRow, ...]:
    """Apply every micro-rotation; z gains `counts` times the angle turned."""
    rows = []
    state = start
    eta = sequence.eta or (None,) * len(sequence.shifts)
    for index, (shift, digit) in enumerate(zip(sequence.shifts, eta, strict=False), 1):
        state = _step(sequence, state, shift, digit, rule(state), counts)
        rows.append(IterationRow(index, shift, digit, state))
    return tuple(rows)


def _step(sequence: Sequence, s: State, shift: int, eta: int | None, sigma: int, counts: int) -> State:
    """Apply one micro-rotation: standard, or root-free (eq. 13) with the scaling of eq. 16 if any."""
    m, h = sequence.m, mp.ldexp(mp.mpf(1), -shift)
    z = s.z + counts * sigma * counted_angle(sequence, shift)
    if not sequence.root_free:
        stretch = mp.sqrt(1 + m * h * h)
        x, y = s.x - m * sigma * h * s.y, s.y + sigma * h * s.x
    else:
        stretch = 1 + m * h * h
        keep = 1 - m * h * h
        x, y = keep * s.x - 2 * m * sigma * h * s.y, keep * s.y + 2 * sigma * h * s.x
    if eta is not None:
        scale = 1 - eta * h * h
        return State(x * scale, y * scale, z, s.target)
    return State(x, y, z, None if s.target is None else s.target * stretch)
