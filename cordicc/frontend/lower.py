"""Syntax trees to graph values, constants folded and nothing else changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Call, Expr, Name, Neg, Number, Power, Product, Sum, Vector, postorder
from cordicc.frontend.scope import Scope, Text
from cordicc.ir.graph import Builder, Param, Value
from cordicc.ir.meaning.exact import FoldError, fold
from cordicc.ir.ops import OPS

MAX_EXPONENT = 64


def emit(builder: Builder, op: str, operands: Sequence[Value], params: Sequence[Param] = ()) -> Value:
    """Return the result of an operation, folded if all operands are constants; raises FoldError."""
    numbers = [builder.constant(v) for v in operands]
    if op == "div" and numbers[1] == 0:
        raise FoldError("division by zero")
    known = [n for n in numbers if n is not None]
    if len(known) == len(numbers):
        return builder.const(fold(op, params, known))
    return builder.emit(op, operands, params)


def checked_exponent(exponent: Fraction | None, expr: Power) -> Fraction:
    """Return the exponent of a power if it is one that is supported; raises ExpressionError."""
    at = expr.exponent.at
    if exponent is None:
        raise ExpressionError(
            "E210", "the exponent must be a constant", *at, "exp(b*log(a)) is a**b for a > 0"
        )
    if exponent.denominator not in (1, 2):
        hint = "exp(b*log(a)) is a**b for a > 0"
        raise ExpressionError("E210", "the exponent must be an integer or half-integer", *at, hint)
    if abs(exponent) > MAX_EXPONENT:
        raise ExpressionError("E210", f"the exponent is larger than {MAX_EXPONENT} in magnitude", *at)
    return exponent


def lower(expr: Expr, scope: Scope, text: Text, target: str | None = None) -> Value | None:
    """Return the value of an expression in the definition of `target`.

    None, with diagnostics, if it has none; all unknown names in it are reported.
    """
    return lower_all(expr, scope, text, target)[id(expr)]


def lower_all(expr: Expr, scope: Scope, text: Text, target: str | None) -> dict[int, Value | None]:
    """Return the value of every subexpression, by identity."""
    values: dict[int, Value | None] = {}
    for part in postorder(expr):
        try:
            values[id(part)] = _lower_one(part, values, scope, text, target)
        except FoldError as error:
            scope.report.error("E209", str(error), text.span(part.at))
            values[id(part)] = None
        except ExpressionError as error:
            text.report(scope.report, error)
            values[id(part)] = None
    return values


def _lower_one(
    expr: Expr, values: Mapping[int, Value | None], scope: Scope, text: Text, target: str | None
) -> Value | None:
    builder = scope.builder
    match expr:
        case Number(number, unit=unit):
            if unit in scope.values:
                hint = f"write {unit} with '*' for a product, or the number in m or rad"
                message = f"'{unit}' after a number is a unit, and a name here"
                raise ExpressionError("E116", message, *expr.at, hint)
            return builder.const(number)
        case Name():
            return scope.lookup(expr, text, target)
        case Power(base, exponent):
            low, high = values[id(base)], values[id(exponent)]
            if low is None or high is None:
                return None
            return power(builder, low, checked_exponent(builder.constant(high), expr))
        case Neg(operand):
            value = values[id(operand)]
            return None if value is None else emit(builder, "neg", [value])
        case Sum(operands, signs) | Product(operands, signs):
            parts = [values[id(o)] for o in operands]
            ops = ("add", "sub") if isinstance(expr, Sum) else ("mul", "div")
            return _chain(builder, parts, [ops[sign < 0] for sign in signs])
        case Call(function, args):
            parts = [values[id(a)] for a in args]
            if function in ("min", "max"):
                return _chain(builder, parts, [function] * len(parts))
            known = [p for p in parts if p is not None]
            return emit(builder, function, known) if len(known) == len(parts) else None
        case Vector():
            raise AssertionError("vectors are expanded before names are looked up")


def _chain(builder: Builder, parts: Sequence[Value | None], ops: Sequence[str]) -> Value | None:
    """Return parts combined from the left; the first operation is not used."""
    if any(p is None for p in parts):
        return None
    result = parts[0]
    for part, op in zip(parts[1:], ops[1:], strict=True):
        assert result is not None
        assert part is not None
        result = emit(builder, op, [result, part])
    return result


def power(builder: Builder, base: Value, exponent: Fraction) -> Value:
    """Return base**exponent; a zeroth power keeps the domain of its base."""
    if exponent == 0:
        one = builder.const(1)
        plain = builder.nodes[base.node].op in ("const", "input")
        return one if plain else builder.emit("guard", [one, base], ("any",))
    return base if exponent == 1 else emit(builder, "pow", [base], (exponent,))


@dataclass(frozen=True, slots=True)
class LinearForm:
    """What of an expression is a sum: multiples of names, and multiples of inverse circular functions."""

    names: Mapping[str, Fraction] = field(default_factory=dict)
    angles: frozenset[Fraction] = frozenset()

    def scaled(self, factor: Fraction) -> LinearForm:
        """Return the form times a number."""
        if factor == 1:
            return self
        return LinearForm(
            {n: k * factor for n, k in self.names.items()}, frozenset(a * factor for a in self.angles)
        )


ANGLE = LinearForm({}, frozenset({Fraction(1)}))


def linear_form(expr: Expr, values: Mapping[int, Value | None], builder: Builder) -> LinearForm:
    """Return the linear form of an expression whose subexpressions have these values."""
    forms: dict[int, LinearForm] = {}
    for part in postorder(expr):
        form = LinearForm()
        match part:
            case Name(name):
                form = LinearForm({name: Fraction(1)})
            case Neg(operand):
                form = forms[id(operand)].scaled(Fraction(-1))
            case Sum(terms, signs):
                form = _sum([forms[id(t)].scaled(Fraction(s)) for t, s in zip(terms, signs, strict=True)])
            case Product():
                form = _product(part, forms, values, builder)
            case Power(base, exponent):
                high = values[id(exponent)]
                if high is not None and builder.constant(high) == 1:
                    form = forms[id(base)]
            case Call(function) if function in OPS and OPS[function].angle is not None:
                form = ANGLE
        forms[id(part)] = form
    return forms[id(expr)]


def _sum(forms: Sequence[LinearForm]) -> LinearForm:
    names: dict[str, Fraction] = {}
    for form in forms:
        for name, k in form.names.items():
            names[name] = names.get(name, Fraction(0)) + k
    return LinearForm(names, frozenset().union(*(form.angles for form in forms)))


def _product(
    expr: Product, forms: Mapping[int, LinearForm], values: Mapping[int, Value | None], builder: Builder
) -> LinearForm:
    """Return the form of the one factor that is not a constant, times the constants."""
    chosen: LinearForm | None = None
    factor = Fraction(1)
    factors = list(zip(expr.factors, expr.signs, strict=True))
    constants: list[tuple[Expr, int, Fraction]] = []
    for part, sign in factors:
        value = values[id(part)]
        number = builder.constant(value) if value is not None else None
        if number is not None:
            constants.append((part, sign, number))
        elif chosen is not None or sign < 0:
            return LinearForm()
        else:
            chosen = forms[id(part)]
    if chosen is None:
        # all constant: the form of one of them, preferably one that shows an angle
        bearing = [c for c in constants if c[1] > 0 and forms[id(c[0])].angles]
        bearing = bearing or [c for c in constants if c[1] > 0 and forms[id(c[0])].names]
        if not bearing:
            return LinearForm()
        chosen = forms[id(bearing[-1][0])]
        constants.remove(bearing[-1])
    for _, sign, number in constants:
        if sign < 0 and number == 0:
            return LinearForm()
        factor = factor * number if sign > 0 else factor / number
    return chosen.scaled(factor)
