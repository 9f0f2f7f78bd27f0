"""Homogeneous scaling: values as fractions with positive denominators, cleared where an angle is taken.

Both arguments of a vectoring, or all three of an implicit equation, may be multiplied by one positive
number.  So cosine and sine of an angle that a unit made need no rotation: from B c + A s = C with the
second result w, (A^2 + B^2) (c, s) = (B C -+ A w, A C +- B w), and (c, s) = (x, y)/norm for a vectoring.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

from cordicc.ir.graph import Node, Value
from cordicc.ir.meaning.exact import fold
from cordicc.rewrite.exact.field import Element, TooLarge
from cordicc.rewrite.exact.keys import RotorKey
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.angles import angles_of, is_angle
from cordicc.rewrite.rules.products import turned
from cordicc.rewrite.rules.rule import Given, Need, Rule

_MOST = 8
"""Denominators of one value."""


@dataclass(frozen=True, slots=True)
class Ratio:
    """num divided by the product of dens, all of them positive wherever the problem has a value."""

    num: Value
    dens: tuple[Value, ...] = ()


class Lifting:
    """Lifts values of a store; `angles` are those whose cosine and sine become fractions.

    `own` gives, by rotor, angles of implicit units that stand for sums of angles.
    """

    def __init__(
        self, store: Store, angles: frozenset[Value], own: Mapping[RotorKey, Value] | None = None
    ) -> None:
        self.store = store
        self._angles = angles
        self._own = own or {}
        self._done: dict[Value, Ratio] = {}
        self._open: set[Value] = set()

    def lift(self, value: Value) -> Ratio:
        """Return a value as a fraction."""
        todo = [value]
        while todo:
            last = todo[-1]
            if last in self._done:
                todo.pop()
                continue
            pending = [v for v in self.store.node(last).operands if v not in self._done]
            if pending:
                todo += pending
                continue
            for result, ratio in enumerate(self._node(last)):
                sibling = Value(last.node, result)
                self._done[sibling] = self._simplified(sibling, ratio)
            todo.pop()
        return self._done[value]

    def realise(self, value: Value) -> None:
        """Add a value as one quotient, if it is a fraction."""
        ratio, store = self.lift(value), self.store
        if not ratio.dens:
            return
        store.begin(store.node(value).origin)
        COMMON_DENOMINATORS.tell(store, "quotient")
        below = ratio.dens[0]
        for den in ratio.dens[1:]:
            below = store.mul(below, den)
        store.union(value, store.make("vector", (below, ratio.num, store.const(0)), (0, 1))[1])

    # -- arithmetic of fractions ------------------------------------------------------------------

    def common(self, values: Sequence[Ratio]) -> tuple[list[Value], tuple[Value, ...]]:
        """Return numerators over the least common denominator, and that denominator."""
        needed: Counter[Value] = Counter()
        for ratio in values:
            needed |= Counter(ratio.dens)
        dens = tuple(sorted(needed.elements()))
        if len(dens) > _MOST:
            raise TooLarge
        numerators = []
        for ratio in values:
            number = ratio.num
            missing = needed - Counter(ratio.dens)
            for den in sorted(missing.elements()):
                number = self.store.mul(number, den)
            numerators.append(number)
        return numerators, dens

    def _sum(self, a: Ratio, b: Ratio, sign: int = 1) -> Ratio:
        (p, q), dens = self.common([a, b])
        return Ratio(self.store.make("add" if sign == 1 else "sub", (p, q))[0], dens)

    def _product(self, a: Ratio, b: Ratio) -> Ratio:
        top = Counter(a.dens)
        dens = tuple(sorted((top + Counter(b.dens)).elements()))
        for one, other in ((a, b), (b, a)):
            if one.num in other.dens:
                rest = list(dens)
                rest.remove(one.num)
                return Ratio(other.num, tuple(rest))
        return Ratio(self.store.mul(a.num, b.num), dens)

    def _quotient(self, a: Ratio, b: Ratio) -> Ratio:
        """Return a/b; a denominator of unknown sign gives its sign to the numerator."""
        store = self.store
        if store.constant(b.num) == 0:
            raise TooLarge
        (p, q), _ = self.common([a, b])
        number = store.constant(q)
        if number:
            return Ratio(store.scale(1 / number, p))
        sign = store.sign(q)
        if sign < 0:
            return Ratio(store.scale(Fraction(-1), p), (store.scale(Fraction(-1), q),))
        if sign == 0:
            return Ratio(store.make("flip", (p, q))[0], (store.make("abs", (q,))[0],))
        return Ratio(p, (q,))

    def _simplified(self, value: Value, ratio: Ratio) -> Ratio:
        """Return a fraction with fewer denominators if a value is known that it equals."""
        if not ratio.dens:
            return ratio
        store = self.store
        element = store.element(value)
        if element is None or not store.is_transparent(element):
            return ratio
        for count in range(len(ratio.dens)):
            poly = store.field.display(element)
            known = None if poly is None else store.affine(poly)
            if known is not None:
                found, factor, constant = known
                number = store.add(store.scale(factor, found), store.const(constant))
                return Ratio(number, ratio.dens[:count])
            den = store.element(ratio.dens[count])
            if den is None:
                return ratio
            try:
                element = store.field.mul(element, den)
            except TooLarge:
                return ratio
        return ratio

    # -- operations -------------------------------------------------------------------------------

    def _node(self, value: Value) -> tuple[Ratio, ...]:
        store = self.store
        node = store.node(value)
        plain = tuple(Ratio(Value(value.node, i)) for i in range(len(node.definition.results)))
        operands = [self._done[v] for v in node.operands]
        store.begin(node.origin)
        COMMON_DENOMINATORS.tell(store, node.op if node.op in COMMON_DENOMINATORS.cases else "")
        try:
            made = self._lifted(node, operands)
        except (TooLarge, ZeroDivisionError):
            made = None
        if made is None:
            return plain
        for result, ratio in enumerate(made):
            if not ratio.dens:
                store.union(Value(value.node, result), ratio.num)
        return made

    def _lifted(self, node: Node, operands: Sequence[Ratio]) -> tuple[Ratio, ...] | None:
        """Return the results of an operation, whose operands became fractions, as fractions."""
        store, values, params = self.store, node.operands, node.params
        match node.op:
            case "add" | "sub":
                return (self._sum(operands[0], operands[1], 1 if node.op == "add" else -1),)
            case "mul":
                return (self._product(operands[0], operands[1]),)
            case "neg" | "cmul" | "shift" | "abs":
                inner = operands[0]
                return (Ratio(store.make(node.op, (inner.num,), params)[0], inner.dens),)
            case "flip":
                inner = operands[0]
                return (Ratio(store.make("flip", (inner.num, operands[1].num))[0], inner.dens),)
            case "rotate" if node.m == 1 and values[2] in self._angles:
                return self._turned((operands[0], operands[1]), self.rotor(values[2]))
            case "rotate" if node.m != 0:
                (p, q), dens = self.common(operands[:2])
                made = store.make("rotate", (p, q, self._plain(operands[2], values[2])), params)
                return tuple(Ratio(v, dens) for v in made)
            case "vector" if node.m == 0:
                if store.constant(values[2]) != 0:
                    return None
                return operands[0], self._quotient(operands[1], operands[0])
            case "vector":
                (p, q), dens = self.common(operands[:2])
                norm, angle = store.make("vector", (p, q, self._plain(operands[2], values[2])), params)
                return Ratio(norm, dens), Ratio(angle)
            case "lightcone":
                (u, v), dens = self.common(operands)
                root, angle = store.make("lightcone", (u, v))
                return Ratio(root, dens), Ratio(angle)
            case "implicit":
                (A, B, C), dens = self.common(operands)
                angle, rest = store.make("implicit", (A, B, C), params)
                return Ratio(angle), Ratio(rest, dens)
        return None

    @staticmethod
    def _plain(ratio: Ratio, value: Value) -> Value:
        return value if ratio.dens else ratio.num

    # -- cosine and sine as fractions -------------------------------------------------------------

    def rotor(self, angle: Value) -> tuple[Ratio, Ratio]:
        """Return cosine and sine of an angle as fractions.  Raises TooLarge."""
        if angle in self._open:
            # The equation that would give them is made of them.
            raise TooLarge
        self._open.add(angle)
        try:
            return self._rotor(angle)
        finally:
            self._open.remove(angle)

    def _rotor(self, angle: Value) -> tuple[Ratio, Ratio]:
        store = self.store
        node = store.node(angle)
        match node.op:
            case "neg":
                c, s = self.rotor(node.operands[0])
                return c, self._minus(s)
            case "add" | "sub" if self._equal(angle) is not None:
                return self._implicit(self._equal(angle) or angle)
            case "add":
                return self._turned(self.rotor(node.operands[0]), self.rotor(node.operands[1]))
            case "sub":
                c, s = self.rotor(node.operands[1])
                return self._turned(self.rotor(node.operands[0]), (c, self._minus(s)))
            case "wrap" | "guard":
                return self.rotor(node.operands[0])
            case "const":
                number = node.number
                return Ratio(store.const(fold("cos", (), (number,)))), Ratio(
                    store.const(fold("sin", (), (number,)))
                )
            case "vector" if angle.result == node.angle:
                return self._vectored(angle)
            case "implicit" if angle.result == node.angle:
                return self._implicit(angle)
        made = store.make("rotate", (store.const(1), store.const(0), angle), (1,))
        return Ratio(made[0]), Ratio(made[1])

    def _equal(self, angle: Value) -> Value | None:
        """Return an angle of an implicit unit with the same cosine and sine."""
        known = self.store.rotors.rotor(angle) if self._own else None
        return None if known is None else self._own.get((known[0].key, known[1].key))

    def _minus(self, ratio: Ratio) -> Ratio:
        return Ratio(self.store.scale(Fraction(-1), ratio.num), ratio.dens)

    def _turned(self, a: tuple[Ratio, Ratio], b: tuple[Ratio, Ratio]) -> tuple[Ratio, Ratio]:
        """Return a vector turned by an angle with rotor b."""
        (x, y), below = self.common(a)
        (c, s), under = self.common(b)
        first, second = turned(self.store, (x, y), (c, s))
        dens = tuple(sorted((*below, *under)))
        return Ratio(first, dens), Ratio(second, dens)

    def _vectored(self, angle: Value) -> tuple[Ratio, Ratio]:
        """Return (x, y)/norm, turned by the angle in the unit's z input."""
        store = self.store
        node = store.node(angle)
        self.lift(angle)
        start = node.operands[2]
        (x, y), _ = self.common([self._done[v] for v in node.operands[:2]])
        norm = store.make("vector", (x, y, self._plain(self._done[start], start)), node.params)[0]
        own = Ratio(x, (norm,)), Ratio(store.scale(Fraction(node.sign), y), (norm,))
        return own if store.constant(start) == 0 else self._turned(self.rotor(start), own)

    def _implicit(self, angle: Value) -> tuple[Ratio, Ratio]:
        store = self.store
        node = store.node(angle)
        self.lift(angle)
        (A, B, C), _ = self.common([self._done[v] for v in node.operands])
        w = store.make("implicit", (A, B, C), node.params)[1]
        w = w if node.branch == "-" else store.scale(Fraction(-1), w)
        for zero, other, pair in ((A, B, (C, self._minus(Ratio(w)).num)), (B, A, (w, C))):
            # With one coefficient k the formula is (C, -w)/k or (w, C)/k.
            if store.constant(zero) == 0 and store.sign(other) > 0:
                number = store.constant(other)
                if number:
                    return Ratio(store.scale(1 / number, pair[0])), Ratio(store.scale(1 / number, pair[1]))
                return Ratio(pair[0], (other,)), Ratio(pair[1], (other,))
        size = store.add(store.mul(A, A), store.mul(B, B))
        cosine = store.add(store.mul(B, C), store.mul(A, w))
        sine = store.make("sub", (store.mul(A, C), store.mul(B, w)))[0]
        number = store.constant(size)
        if number:
            return Ratio(store.scale(1 / number, cosine)), Ratio(store.scale(1 / number, sine))
        return Ratio(cosine, (size,)), Ratio(sine, (size,))


def _rotor(store: Store, angle: Value) -> tuple[Element | None, ...]:
    """Return cosine and sine of an angle, where they are known."""
    return store.rotors.rotor(angle) or ()


def _roots(store: Store, *elements: Element | None) -> set[int]:
    """Return the roots that occur in elements."""
    return set(store.field.roots_of(*(element for element in elements if element is not None)))


_SUBSETS = 16
"""Sets of angles up to which all of them are tried."""


def _lift(given: Given) -> None:
    """Add homogeneous versions of all values, for sets of angles whose rotations are replaced."""
    store = given.store
    turned = sorted(
        {n.operands[2] for n in store.algebra.nodes if n.op == "rotate" and n.m == 1},
    )
    kept = _roots(store, *(store.element(value) for value in given.apart))
    lifted = [z for z in turned if is_angle(store, z) and kept.isdisjoint(_roots(store, *_rotor(store, z)))]
    size = len(store.algebra.nodes)
    own: dict[RotorKey, Value] = {}
    for value in angles_of(store):
        rotor = store.rotors.rotor(value) if store.node(value).op == "implicit" else None
        if rotor is not None:
            own.setdefault((rotor[0].key, rotor[1].key), value)
    for lifting in [Lifting(store, frozenset(lifted), own)] + [
        Lifting(store, frozenset(chosen)) for chosen in _subsets(lifted)
    ]:
        for value in given.outputs.values():
            lifting.realise(value)
        for index in range(size):
            if store.node(Value(index)).op in ("vector", "lightcone", "implicit"):
                lifting.lift(Value(index))


def _subsets(items: Sequence[Value]) -> list[tuple[Value, ...]]:
    """Return all subsets, or for many items the empty, full, nearly empty and nearly full ones."""
    if 2 ** len(items) <= _SUBSETS:
        return [c for size in range(len(items) + 1) for c in combinations(items, size)]
    sizes = (0, 1, len(items) - 1, len(items))
    return [c for size in sizes for c in combinations(items, size)]


COMMON_DENOMINATORS = Rule(
    name="common denominators",
    mathematics="p/d + q/e = (p e + q d)/(d e), and atan2(y/d, x/d) = atan2(y, x) for d > 0",
    apply=_lift,
    needs=frozenset({Need.OUTPUTS, Need.LIFTING}),
    words="taken over the common positive denominator",
    cases={
        "vector": "both arguments multiplied by their positive common denominator: the angle stays",
        "implicit": "`A`, `B` and `C` multiplied by their positive common denominator: the angle stays",
        "rotate": "cosine and sine of the angle as fractions of what its unit yields: no rotation",
        "quotient": "one quotient, by the product of all denominators",
    },
)
