"""Cosine and sine of angles as elements of the field."""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.graph import Node, Value
from cordicc.rewrite.exact.constants import Constants, Rotor
from cordicc.rewrite.exact.field import TooLarge
from cordicc.rewrite.exact.keys import ElementKey
from cordicc.rewrite.exact.known_values import KnownValues

_UNITS = ("vector", "implicit", "lightcone")

MOST_TURNS = 4
"""The largest multiple of an angle whose cosine and sine are expanded."""


class Rotors:
    """Finds rotors: cosine and sine (m = 1), or hyperbolic cosine and sine (m = -1), of angles."""

    def __init__(self, constants: Constants, known: KnownValues) -> None:
        self._constants, self._known = constants, known
        self.field = constants.field
        self.turned: dict[int, tuple[Value, int, int]] = {}
        self._rotors: dict[tuple[Value, int], Rotor | None] = {}
        self._touched: dict[tuple[Value, int], frozenset[str]] = {}
        self._atoms: dict[tuple[Value | ElementKey, int], Rotor] = {}
        self._grains: dict[Value, tuple[Fraction, Value]] = {}

    def grain(self, value: Value, share: Fraction, part: Value) -> None:
        """Take multiples of a value, which is no angle of a unit, for multiples of its part share * value."""
        self._grains[self._known.find(value)] = share, part

    def turn(self, vector: Rotor, rotor: Rotor, m: int = 1) -> Rotor:
        """Return a vector turned by an angle."""
        field, (x, y), (c, s) = self.field, vector, rotor
        return (
            field.sub(field.mul(x, c), field.scale(Fraction(m), field.mul(y, s))),
            field.add(field.mul(y, c), field.mul(x, s)),
        )

    def back(self, rotor: Rotor) -> Rotor:
        """Return the rotor of the opposite angle."""
        return rotor[0], self.field.scale(Fraction(-1), rotor[1])

    def rotor(self, value: Value, m: int = 1) -> Rotor | None:
        """Return cosine and sine of an angle, None where they are too large."""
        if (value, m) not in self._rotors:
            before, self.field.touched = self.field.touched, set()
            try:
                self._rotors[value, m] = self._found(value, m)
            finally:
                touched, self.field.touched = frozenset(self.field.touched), before
            self._touched[value, m] = touched
        self.field.touched |= self._touched[value, m]
        return self._rotors[value, m]

    def known_rotor(self, value: Value) -> Rotor | None:
        """Return the circular rotor of an angle for which it was asked before."""
        return self._rotors.get((value, 1))

    def forget(self, index: int) -> None:
        """Forget the rotors of a node's results, whose operands have changed."""
        for key in [key for key in self._rotors if key[0].node == index]:
            del self._rotors[key], self._touched[key]

    def _found(self, value: Value, m: int) -> Rotor | None:
        while True:
            try:
                return self._rotor(value, m)
            except TooLarge:
                if self._known.node(value).op not in _UNITS or not self._known.reopened(value.node):
                    return None
            except ZeroDivisionError:
                return None

    def _rotor(self, value: Value, m: int) -> Rotor | None:
        node, field = self._known.node(value), self.field
        fine = self._of_grains(value, m)
        if fine is not None:
            return fine
        inner = [self.rotor(v, m) for v in node.operands] if node.op in ("add", "sub", "neg") else []
        known = [r for r in inner if r is not None]
        if len(known) < len(inner):
            return None
        angle = node.angle if m == 1 else node.hyperbolic_angle
        match node.op:
            case "neg":
                return self.back(known[0])
            case "add":
                return self.turn(known[0], known[1], m)
            case "sub":
                return self.turn(known[0], self.back(known[1]), m)
            case "wrap" | "guard" if m == 1 or node.op == "guard":
                return self.rotor(node.operands[0], m)
            case "cmul" | "shift":
                factor = node.factor if node.op == "cmul" else Fraction(2) ** int(node.exponent)
                if factor.denominator == 1 and abs(factor) <= MOST_TURNS:
                    return self._multiple(node.operands[0], int(factor), m)
            case "const":
                return self._constants.rotor(node.number, m)
            case "vector" if value.result == angle:
                return self._vector_rotor(value, node, m)
            case "implicit" if value.result == angle:
                return self._implicit_rotor(value, node, m)
            case "lightcone" if value.result == angle:
                u, v, root = (self._known.element(x) for x in (*node.operands, Value(value.node)))
                interval = self._known.range(node.operands[0])
                if u is None or v is None or root is None or interval is None or interval.lo <= 0:
                    return None
                half = field.div(field.number(Fraction(1, 2)), root)
                return field.mul(half, field.add(u, v)), field.mul(half, field.sub(u, v))
        return self._atom(value, m)

    def _of_grains(self, value: Value, m: int) -> Rotor | None:
        """Return the rotor of a multiple of a value that is measured in a part of it."""
        factor, base = self._known.factored(value)
        share, part = self._grains.get(self._known.find(base), (Fraction(1), base))
        times = factor / share
        if part == base or times.denominator != 1 or not 0 < abs(times) <= MOST_TURNS:
            return None
        return self._repeated(self._atom(part, m), int(times), m)

    def _multiple(self, value: Value, factor: int, m: int) -> Rotor | None:
        one = self.rotor(value, m)
        return None if one is None else self._repeated(one, factor, m)

    def _repeated(self, one: Rotor, factor: int, m: int) -> Rotor:
        one = one if factor > 0 else self.back(one)
        whole = one
        for _ in range(abs(factor) - 1):
            whole = self.turn(whole, one, m)
        return whole

    def _atom(self, value: Value, m: int) -> Rotor:
        """Return new generators for the cosine and sine of a value that is no angle of a unit."""
        element = self._known.element(value)
        key = (self._known.find(value) if element is None else element.key, m)
        if key not in self._atoms:
            c, s, *rotor = self.field.pair(m)
            self._atoms[key] = rotor[0], rotor[1]
            self.turned |= {c: (value, m, 0), s: (value, m, 1)}
        return self._atoms[key]

    def _vector_rotor(self, value: Value, node: Node, m: int) -> Rotor | None:
        field = self.field
        x, y = (self._known.element(v) for v in node.operands[:2])
        norm, start = self._known.element(Value(value.node)), self.rotor(node.operands[2], m)
        if x is None or y is None or norm is None or start is None:
            return None
        interval = self._known.range(node.operands[0])
        if m == -1 and (interval is None or interval.lo <= 0):
            return self._atom(value, m)
        inverse = field.inverse(norm)
        y = field.scale(Fraction(node.sign), y)
        return self.turn(start, (field.mul(x, inverse), field.mul(y, inverse)), m)

    def _implicit_rotor(self, value: Value, node: Node, m: int) -> Rotor | None:
        """Return the rotor from B c + A s = C and A c - m B s = -+w, w the second result."""
        field, branch = self.field, node.branch
        given = [self._known.element(v) for v in node.operands]
        w = self._known.element(Value(value.node, 1))
        A, B, C = given
        if A is None or B is None or C is None or w is None:
            return None
        size = field.add(field.mul(B, B), field.scale(Fraction(m), field.mul(A, A)))
        if m == -1:
            lead = self._known.range(node.operands[0 if branch == "none" else 1])
            if lead is None or lead.lo <= 0:
                return self._atom(value, m)
        # The slope -B s + A c (m = 1), B s + A c (m = -1) at the solution: -w for "+" in the circular case.
        rising = (branch == "-") if m == 1 else (branch != "-")
        w = w if rising else field.scale(Fraction(-1), w)
        inverse = field.inverse(size)
        cosine = field.add(field.mul(B, C), field.scale(Fraction(m), field.mul(A, w)))
        sine = field.sub(field.mul(A, C), field.mul(B, w))
        return field.mul(cosine, inverse), field.scale(Fraction(m), field.mul(sine, inverse))
