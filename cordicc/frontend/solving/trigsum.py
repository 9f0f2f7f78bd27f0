"""Sums of cosines and sines of two unknowns, with graph values as coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Call, Expr, Name, Neg, Product, Sum, children, postorder
from cordicc.frontend.lower import emit, lower
from cordicc.frontend.scope import Scope, Text
from cordicc.frontend.solving.polynomial import Coefficients
from cordicc.ir.graph import Value

Multiples = tuple[int, int]
_FORM = "each term must be a coefficient times the cosine or sine of the unknowns, or without them"


class Harmonic(NamedTuple):
    """The cosine or sine of integer multiples of the unknowns plus an offset.

    The first multiple that is not 0 is positive.
    """

    multiples: Multiples
    offset: Value
    function: str


TrigSum = Mapping[Harmonic | None, Value]
"""Coefficients by terms; None stands for the part without unknowns."""


class TrigSums:
    """Expands expressions that are linear in cosines and sines of two unknowns."""

    def __init__(self, scope: Scope, text: Text, unknowns: tuple[str, ...], maths: Coefficients) -> None:
        self.scope = scope
        self.text = text
        self.unknowns = unknowns
        self.maths = maths
        self._bound: set[int] = set()

    def add(self, p: TrigSum, q: TrigSum, sign: int = 1) -> TrigSum:
        """Return p + sign * q."""
        zero = self.maths.builder.const(0)
        total = dict(p)
        for term, value in q.items():
            total[term] = self.maths.plus(total.get(term, zero), value, sign)
        return {term: value for term, value in total.items() if value != zero}

    def expand(self, expr: Expr) -> TrigSum | None:
        """Return the sum that an expression is; None, with diagnostics, if a name in it has no value.

        Raises ExpressionError where it is no such sum.
        """
        for part in postorder(expr):
            own = isinstance(part, Name) and part.name in self.unknowns
            if own or any(id(child) in self._bound for child in children(part)):
                self._bound.add(id(part))
        found: dict[int, TrigSum | None] = {}
        for part in self._outer(expr):
            found[id(part)] = self._one(part, found)
        return found[id(expr)]

    def _outer(self, expr: Expr) -> list[Expr]:
        """Return the parts in order of evaluation, without what is inside functions or free parts."""
        order, todo = [], [expr]
        while todo:
            part = todo.pop()
            order.append(part)
            if id(part) in self._bound and not isinstance(part, Call):
                todo.extend(children(part))
        return order[::-1]

    def _one(self, expr: Expr, found: Mapping[int, TrigSum | None]) -> TrigSum | None:
        if id(expr) not in self._bound:
            value = lower(expr, self.scope, self.text)
            return None if value is None else {None: value}
        if isinstance(expr, Call):
            return self._call(expr)
        parts = [part for child in children(expr) if (part := found[id(child)]) is not None]
        if len(parts) < len(children(expr)):
            return None
        match expr:
            case Neg():
                return self.add({}, parts[0], -1)
            case Sum(_, signs):
                total: TrigSum = {}
                for part, sign in zip(parts, signs, strict=True):
                    total = self.add(total, part, sign)
                return total
            case Product(factors, signs):
                return self._product(expr, factors, signs, parts)
            case Name(name):
                message = f"'{name}' appears outside sin and cos: the equation is transcendental in {name}"
                raise ExpressionError("E301", message, *expr.at)
            case _:
                raise ExpressionError("E311", _FORM, *expr.at)

    def _product(
        self, expr: Product, factors: tuple[Expr, ...], signs: tuple[int, ...], parts: list[TrigSum]
    ) -> TrigSum:
        maths, zero = self.maths, self.maths.builder.const(0)
        result = parts[0]
        bound = id(factors[0]) in self._bound
        for factor, part, sign in list(zip(factors, parts, signs, strict=True))[1:]:
            if id(factor) in self._bound:
                if bound or sign < 0:
                    hint = "write products of cosines and sines as those of sums: cos(u + v)"
                    raise ExpressionError("E311", _FORM, *expr.at, hint)
                value = result.get(None, zero)
                result, bound = {t: maths.product(v, value) for t, v in part.items()}, True
                continue
            value = part.get(None, zero)
            if sign > 0:
                result = {t: maths.product(v, value) for t, v in result.items()}
            else:
                result = {t: emit(maths.builder, "div", [v, value]) for t, v in result.items()}
        return {term: value for term, value in result.items() if value != zero}

    def _call(self, expr: Call) -> TrigSum | None:
        if expr.function not in ("cos", "sin"):
            message = f"the unknowns may appear in cos and sin alone, not inside {expr.function}"
            raise ExpressionError("E301", message, *expr.at)
        argument = self._argument(expr.args[0])
        if argument is None:
            return None
        multiples, offset = argument
        if multiples == (0, 0):
            return {None: emit(self.maths.builder, expr.function, [offset])}
        one = self.maths.builder.const(1)
        if multiples > (0, 0):
            return {Harmonic(multiples, offset, expr.function): one}
        mirrored = Harmonic((-multiples[0], -multiples[1]), self.maths.negative(offset), expr.function)
        if self.maths.builder.constant(offset) == 0:
            mirrored = mirrored._replace(offset=offset)
        return {mirrored: one if expr.function == "cos" else self.maths.negative(one)}

    def _argument(self, expr: Expr) -> tuple[Multiples, Value] | None:
        """Return (multiples, offset) of an argument; None if a name in it has no value."""
        maths = self.maths
        zero = maths.builder.const(0)
        found: dict[int, tuple[Multiples, Value]] = {}
        for part in self._outer(expr):
            if id(part) not in self._bound:
                value = lower(part, self.scope, self.text)
                if value is None:
                    return None
                found[id(part)] = ((0, 0), value)
                continue
            match part:
                case Name(name):
                    own = (int(name == self.unknowns[0]), int(name == self.unknowns[1]))
                    found[id(part)] = (own, zero)
                case Neg() | Sum():
                    signs = part.signs if isinstance(part, Sum) else (-1,)
                    first = second = 0
                    rest = zero
                    for child, sign in zip(children(part), signs, strict=True):
                        multiples, offset = found[id(child)]
                        first, second = first + sign * multiples[0], second + sign * multiples[1]
                        rest = maths.plus(rest, offset, sign)
                    found[id(part)] = ((first, second), rest)
                case _:
                    message = (
                        "the argument must be a sum or difference of the unknowns and terms without them"
                    )
                    raise ExpressionError("E311", message, *part.at)
        return found[id(expr)]
