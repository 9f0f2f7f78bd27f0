"""Denavit-Hartenberg tables, expanded to the entries of the frame at the end of the arm.

Standard: each joint is Rz(theta) Tz(d) Tx(a) Rx(alpha); modified (Craig): Rx(alpha) Tx(a) Rz(theta) Tz(d).
Every column of the frame is a vector carried from the last joint to the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from cordicc.expressions.syntax import Expr, Number, Place
from cordicc.frontend.plain.expansion import Expansion, is_number, quarter_turns

STANDARD, MODIFIED = "standard", "modified"
CONVENTIONS = (STANDARD, MODIFIED)
FIELDS = ("theta", "d", "a", "alpha")
MAX_JOINTS = 32
"""Joints of a table."""

MAX_ALL_JOINTS = 512
"""Joints of all tables of a file."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A row of the table: angles in radians, lengths in the user's unit."""

    theta: Expr
    d: Expr
    a: Expr
    alpha: Expr


def frame_entries(frame: str) -> list[str]:
    """Return the names of the entries of a frame: its axes by columns, then its origin."""
    axes = [f"{frame}_r{row}{column}" for column in (1, 2, 3) for row in (1, 2, 3)]
    return axes + [f"{frame}_p{axis}" for axis in "xyz"]


def expand_table(joints: Sequence[Joint], convention: str, make: Expansion, at: Place) -> list[Expr]:
    """Return the entries of the frame at the end of the arm, in the order of `frame_entries`."""
    found: list[Expr] = []
    for column in range(4):
        start = [Number(Fraction(column == row), at) for row in range(3)]
        vector = _Carried(make, start[2], [_PlaneVector([], start[0], start[1])])
        for joint in reversed(joints):
            if convention == STANDARD:
                vector.about_x(joint.alpha)
                if column == 3:
                    vector.shift(joint.a, joint.d)
                vector.about_z(joint.theta)
            else:
                if column == 3:
                    vector.shift(Number(Fraction(0), at), joint.d)
                vector.about_z(joint.theta)
                if column == 3:
                    vector.shift(joint.a, Number(Fraction(0), at))
                vector.about_x(joint.alpha)
        found += [*vector.flat(), vector.z]
    return found


@dataclass(slots=True)
class _PlaneVector:
    """A plane vector (x, y), still to be turned by a sum of angles about z."""

    angles: list[tuple[Expr, int]]
    x: Expr
    y: Expr


@dataclass(slots=True)
class _Carried:
    """A vector on its way to the base, its x and y as a sum of turned vectors.

    Turns about parallel axes are added up before they are carried out: they need one rotation for each
    link, side by side, instead of one after the other.
    """

    make: Expansion
    z: Expr
    plane: list[_PlaneVector] = field(default_factory=list)

    def shift(self, a: Expr, d: Expr) -> None:
        """Move by a along x and by d along z."""
        self.z = self.make.plus(self.z, self.make.plain(d))
        a = self.make.plain(a)
        last = self.plane[-1]
        if is_number(a, 0):
            return
        if last.angles:
            self.plane.append(_PlaneVector([], a, Number(Fraction(0), a.at)))
        else:
            last.x = self.make.plus(last.x, a)

    def about_z(self, theta: Expr) -> None:
        """Turn about z."""
        if self.make.number(theta) == 0:
            return
        for part in self.plane:
            part.angles = [*self.make.angle(theta), *part.angles]

    def about_x(self, alpha: Expr) -> None:
        """Turn about x; a half turn reverses what is still to be done about z."""
        number = self.make.number(alpha)
        quarters = None if number is None else quarter_turns(number)
        if quarters == 0:
            return
        if quarters == 2:
            for part in self.plane:
                part.angles = [(angle, -sign) for angle, sign in part.angles]
                part.y = self.make.negative(part.y)
            self.z = self.make.negative(self.z)
            return
        x, y = self.flat()
        y, self.z = self.make.turn(y, self.z, self.make.angle(alpha))
        self.plane = [_PlaneVector([], x, y)]

    def flat(self) -> tuple[Expr, Expr]:
        """Return x and y after all turns."""
        x: Expr = Number(Fraction(0), self.z.at)
        y: Expr = x
        for part in self.plane:
            u, v = self.make.turn(part.x, part.y, part.angles)
            x, y = self.make.plus(x, u), self.make.plus(y, v)
        return x, y
