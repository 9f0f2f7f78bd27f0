"""Makes plain expressions: zeros and ones are spared, quarter turns exact, shared parts named."""

from __future__ import annotations

from fractions import Fraction

from cordicc.base.diagnostics import Report, Span
from cordicc.expressions.syntax import Call, Expr, Name, Neg, Number, Place, Product, Sum, names
from cordicc.frontend.lower import lower
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.scope import BUILT_IN, FileText, Scope
from cordicc.frontend.trees import check_size
from cordicc.ir.graph import Builder
from cordicc.ir.meaning.exact import fold

_ZERO, _ONE = Fraction(0), Fraction(1)
_SPARED = (_ZERO, _ONE, -_ONE)
_QUARTERS = {(_ONE, _ZERO): 0, (_ZERO, _ONE): 1, (-_ONE, _ZERO): 2, (_ZERO, -_ONE): 3}


class Expansion:
    """The plain equations that one item of the file stands for.

    `label` names the item; `unknowns` are the names that have no value yet, so that no part with
    one of them can be an equation of its own.  Places are offsets into the file.
    """

    def __init__(
        self, scope: Scope, text: FileText, label: str, unknowns: frozenset[str] = frozenset()
    ) -> None:
        self.scope = scope
        self.text = text
        self.label = label
        self.unknowns = unknowns
        self.hidden: list[ParsedEquation] = []
        self._depends: dict[str, frozenset[str]] = {}
        self._names: dict[Expr, str] = {}
        self._numbers: dict[int, tuple[Expr, Fraction | None]] = {}  # by identity, which the tree keeps

    def number(self, expr: Expr) -> Fraction | None:
        """Return the number of an expression of constants alone; None for others or without a value."""
        if id(expr) not in self._numbers:
            self._numbers[id(expr)] = (expr, self._number(expr))
        return self._numbers[id(expr)][1]

    def _number(self, expr: Expr) -> Fraction | None:
        builder = Builder()
        quiet = Scope(builder, Report())
        for name in names(expr):
            value = self.scope.values.get(name.name)
            known = self.scope.builder.constant(value) if value is not None else BUILT_IN.get(name.name)
            if known is None:
                return None
            quiet.define(name.name, builder.const(known), 0)
        lowered = lower(expr, quiet, self.text)
        return None if lowered is None else builder.constant(lowered)

    def plain(self, expr: Expr) -> Expr:
        """Return the expression, a literal if it is 0, 1 or -1."""
        number = self.number(expr)
        return Number(number, expr.at) if number is not None and number in _SPARED else expr

    def plus(self, a: Expr, b: Expr, sign: int = 1) -> Expr:
        """Return a + sign * b."""
        if is_number(b, 0):
            return a
        if is_number(a, 0):
            return b if sign > 0 else self.negative(b)
        if isinstance(b, Neg):
            b, sign = b.operand, -sign
        if isinstance(a, Sum):  # sums are n-ary, so that long ones are not deep
            return Sum((*a.terms, b), (*a.signs, sign), _around(a, b))
        return Sum((a, b), (1, sign), _around(a, b))

    def negative(self, a: Expr) -> Expr:
        """Return -a."""
        if isinstance(a, Number):
            return Number(-a.value, a.at)
        return a.operand if isinstance(a, Neg) else Neg(a, a.at)

    def times(self, a: Expr, b: Expr) -> Expr:
        """Return a * b."""
        for one, other in ((a, b), (b, a)):
            if is_number(one, 0):
                return one
            if is_number(one, 1):
                return other
            if is_number(one, -1):
                return self.negative(other)
        if isinstance(a, Neg) or isinstance(b, Neg):
            product = self.times(*(e.operand if isinstance(e, Neg) else e for e in (a, b)))
            return product if isinstance(a, Neg) and isinstance(b, Neg) else self.negative(product)
        return Product((a, b), (1, 1), _around(a, b))

    def turn(self, u: Expr, v: Expr, terms: list[tuple[Expr, int]]) -> tuple[Expr, Expr]:
        """Return the plane vector (u, v) turned by a sum of angles, constant multiples of pi/2 exactly."""
        rest: list[tuple[Expr, int]] = []
        quarters = 0
        constants = [(e, s, n) for e, s in terms if (n := self.number(e)) is not None]
        total = sum((s * n for _, s, n in constants), Fraction(0))
        exact = quarter_turns(total)
        if exact is not None:
            quarters, rest = exact, [(e, s) for e, s in terms if self.number(e) is None]
        else:
            rest = list(terms)
        for _ in range(quarters):
            u, v = self.negative(v), u
        if not rest or (is_number(u, 0) and is_number(v, 0)):
            return u, v
        sense = rest[0][1]
        angle = self.share(summed([(e, s * sense) for e, s in rest]))
        cosine, sine = (self.plain(Call(name, (angle,), angle.at)) for name in ("cos", "sin"))
        u, v = self.share(u), self.share(v)
        return (
            self.plus(self.times(u, cosine), self.times(v, sine), -sense),
            self.plus(self.times(v, cosine), self.times(u, sine), sense),
        )

    def angle(self, expr: Expr) -> list[tuple[Expr, int]]:
        """Return an angle as a sum of at most one part that varies, which is shared, and constants."""
        terms = angle_terms(expr)
        varying = [(e, s) for e, s in terms if self.number(e) is None]
        if len(varying) > 1:
            sign = varying[0][1]
            varying = [(self.share(summed([(e, s * sign) for e, s in varying])), sign)]
        return varying + [(e, s) for e, s in terms if self.number(e) is not None]

    def share(self, expr: Expr) -> Expr:
        """Return a name for an expression that is used several times, itself if that is no gain."""
        if isinstance(expr, Neg):
            return self.negative(self.share(expr.operand))
        if isinstance(expr, Number | Name):
            return expr
        check_size(expr)
        if any(name.name in self.unknowns for name in names(expr)):
            return expr
        hidden = self._names.get(expr)
        if hidden is None:
            hidden = self._names[expr] = f"{self.label}.{len(self.hidden) + 1}"
            self.hidden.append(self.equation(hidden, expr, hidden=True))
        return Name(hidden, expr.at)

    def equation(
        self, target: str, expr: Expr, span: Span | None = None, written: str = "", hidden: bool = False
    ) -> ParsedEquation:
        """Return an equation of the item, with the names of the file that it rests on."""
        check_size(expr)
        own = frozenset(name.name for name in names(expr))
        if hidden:
            self._depends[target] = self.depends(own)
        span = self.text.span(expr.at) if span is None else span
        return ParsedEquation(
            target, span, written, (expr, self.text),
            label=self.label if hidden or target != self.label else "", hidden=hidden,
            depends=self.depends(own),
        )  # fmt: skip

    def depends(self, own: frozenset[str]) -> frozenset[str]:
        """Return the names of the file behind names some of which are hidden."""
        return frozenset().union(*(self._depends.get(name, frozenset({name})) for name in own))


def quarter_turns(angle: Fraction) -> int | None:
    """Return 0 to 3 if a constant angle is that many quarter turns, up to the rounding of pi."""
    found = (fold("cos", (), [angle]), fold("sin", (), [angle]))
    return _QUARTERS.get(found)


def is_number(expr: Expr, number: int) -> bool:
    """Return whether an expression is this literal."""
    return isinstance(expr, Number) and expr.value == number


def angle_terms(angle: Expr) -> list[tuple[Expr, int]]:
    """Return the terms of a sum, nested ones too, with their signs."""
    match angle:
        case Sum(terms, signs):
            return [(t, s * k) for term, s in zip(terms, signs, strict=True) for t, k in angle_terms(term)]
        case Neg(operand):
            return [(t, -s) for t, s in angle_terms(operand)]
        case _:
            return [(angle, 1)]


def summed(terms: list[tuple[Expr, int]]) -> Expr:
    """Return the sum of terms, the first of which has the sign +1."""
    if len(terms) == 1:
        return terms[0][0]
    exprs, signs = zip(*terms, strict=True)
    return Sum(exprs, signs, _around(*exprs))


def _around(*exprs: Expr) -> Place:
    """Return the place of the first of several expressions, or what is around them if they are in order."""
    first, last = exprs[0].at, exprs[-1].at
    return (first[0], last[1]) if first[0] <= last[0] and first[1] <= last[1] else first
