"""Tokens to a syntax tree: a Pratt parser with Python's precedence.

Sums and products are n-ary, so that long ones are not deep.  Places are offsets into the text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeVar

from cordicc.expressions import hints
from cordicc.expressions.lexer import ExpressionError, Kind, Token, tokenize
from cordicc.expressions.quantities import quantity_at

MAX_NESTING = 100

_OF_ONE = "sqrt sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log abs sign"
FUNCTIONS: dict[str, tuple[int, int | None]] = {
    **dict.fromkeys(_OF_ONE.split(), (1, 1)),
    "hypot": (2, 2),
    "atan2": (2, 2),
    "min": (2, None),
    "max": (2, None),
}
"""The functions and how many arguments they take (None: any number)."""

VECTOR_FUNCTIONS: dict[str, tuple[int, int | None]] = {
    "vector": (2, 3),
    "dot": (2, 2),
    "cross": (2, 2),
    "norm": (1, 1),
    "rotate": (2, 3),
}
"""The functions on vectors, which equations may call besides; their names are not reserved."""

CONSTANT_NAMES = ("pi", "deg")
RELATIONS = ("=", ">", "<", ">=", "<=")

Place = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Number:
    """A number literal; one with a unit is in metres or radians."""

    value: Fraction
    at: Place = field(default=(0, 0), compare=False)
    unit: str = field(default="", compare=False)


@dataclass(frozen=True, slots=True)
class Name:
    """A name, not looked up yet."""

    name: str
    at: Place = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Neg:
    """A negation."""

    operand: Expr
    at: Place = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Sum:
    """Terms in order; `signs` has +1 or -1 for each, the first +1."""

    terms: tuple[Expr, ...]
    signs: tuple[int, ...]
    at: Place = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Product:
    """Factors in order; `signs` has +1 for `*` and -1 for `/`, the first +1."""

    factors: tuple[Expr, ...]
    signs: tuple[int, ...]
    at: Place = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Power:
    """`base ** exponent`."""

    base: Expr
    exponent: Expr
    at: Place = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Call:
    """A function with its arguments."""

    function: str
    args: tuple[Expr, ...]
    at: Place = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Vector:
    """Components in brackets, expanded before names are looked up."""

    items: tuple[Expr, ...]
    at: Place = field(default=(0, 0), compare=False)


Expr = Number | Name | Neg | Sum | Product | Power | Call | Vector


@dataclass(frozen=True, slots=True)
class Relation:
    """`left relation right`."""

    left: Expr
    relation: str
    right: Expr
    at: Place


def children(expr: Expr) -> tuple[Expr, ...]:
    """Return the direct subexpressions, in order."""
    match expr:
        case Number() | Name():
            return ()
        case Neg(operand):
            return (operand,)
        case Sum(terms):
            return terms
        case Product(factors):
            return factors
        case Power(base, exponent):
            return (base, exponent)
        case Call(_, args) | Vector(args):
            return args


def postorder(expr: Expr) -> list[Expr]:
    """Return all subexpressions, each after its own, the expression itself last."""
    found: list[Expr] = []
    todo = [expr]
    while todo:
        current = todo.pop()
        found.append(current)
        todo.extend(children(current))
    return found[::-1]


def names(expr: Expr) -> Iterator[Name]:
    """Yield the names in an expression, in order of their places."""
    return (e for e in postorder(expr) if isinstance(e, Name))


def parse_expression(text: str, vectors: bool = False) -> Expr:
    """Return the tree of an expression, with vectors only if they are allowed.

    Raises ExpressionError at the first mistake.
    """
    return _guarded(text, lambda parser: parser.whole(), vectors)


def parse_definition(text: str, vectors: bool = False) -> tuple[Name, Expr]:
    """Return name and expression of `name = expression`; raises ExpressionError."""

    def definition(parser: _Parser) -> tuple[Name, Expr]:
        form = "write the equation as 'name = expression'"
        token = parser.current
        if token.kind is Kind.END:
            raise ExpressionError("E118", "an equation is missing here", token.start, token.end, form)
        ahead = parser.tokens[1] if len(parser.tokens) > 1 else token
        if token.kind is not Kind.NAME or ahead.text != "=":
            if any(t.text == "=" for t in parser.tokens):
                message, hint = "the left side of an equation must be a single new name", form
                hint += "; an equation in an unknown is 'solve: ...' with 'for:'"
            elif ahead.text in ("==", ":"):
                raise ExpressionError(
                    "E117", f"'{ahead.text}' is not used here", ahead.start, ahead.end, form
                )
            else:
                message, hint = "this is not an equation", form
            raise ExpressionError("E118", message, token.start, token.end, hint)
        parser.advance()
        parser.advance()
        return Name(token.text, (token.start, token.end)), parser.whole()

    return _guarded(text, definition, vectors)


def parse_relation(text: str, relations: tuple[str, ...] = ("=",), vectors: bool = False) -> Relation:
    """Return the two sides of `expression relation expression`; raises ExpressionError."""

    def relation(parser: _Parser) -> Relation:
        left = parser.standing_alone()
        token = parser.current
        if token.text not in relations:
            parser.refuse_foreign_operator()
            parser.refuse_adjacent()
            wanted = " or ".join(f"'{r}'" for r in relations)
            found = f"'{token.text}'" if token.text else "the end"
            raise ExpressionError("E118", f"expected {wanted} but found {found}", token.start, token.end)
        parser.advance()
        right = parser.whole()
        return Relation(left, token.text, right, (left.at[0], right.at[1]))

    return _guarded(text, relation, vectors)


_T = TypeVar("_T")


def _guarded(text: str, parse: Callable[[_Parser], _T], vectors: bool = False) -> _T:
    functions = FUNCTIONS | VECTOR_FUNCTIONS if vectors else FUNCTIONS
    try:
        return parse(_Parser(tokenize(text, brackets=vectors), functions))
    except RecursionError:
        raise ExpressionError("E104", "the expression is nested too deeply", 0, len(text)) from None


_SUM, _PRODUCT, _UNARY, _POWER = 10, 20, 30, 40
_BINDING = {"+": _SUM, "-": _SUM, "*": _PRODUCT, "/": _PRODUCT, "**": _POWER}


class _Parser:
    def __init__(self, tokens: list[Token], functions: Mapping[str, tuple[int, int | None]]) -> None:
        self.tokens = tokens
        self.functions = functions
        self.position = 0
        self.depth = 0
        self.open: list[Token] = []

    @property
    def current(self) -> Token:
        return self.tokens[self.position]

    def advance(self) -> Token:
        token = self.tokens[self.position]
        self.position += 1
        return token

    def whole(self) -> Expr:
        """Return the expression that takes all the tokens left."""
        expr = self.standing_alone()
        token = self.current
        if token.kind is not Kind.END:
            self.refuse_foreign_operator()
            self.refuse_adjacent()
            if token.text == ")":
                raise _error("E113", "')' without '('", token)
            if token.text in RELATIONS:
                raise _error("E118", f"'{token.text}' is not expected here", token)
            raise _error("E112", f"'{token.text}' is not expected here", token)
        return expr

    def standing_alone(self) -> Expr:
        """Return an expression that is a whole side or argument: there a number may have a unit."""
        sign = self.current
        signed = sign.text in ("-", "+")
        found = quantity_at(self.tokens, self.position + signed)
        if found is None:
            return self.expression(0)
        self.position += 2 + signed
        number, at = Number(found.value, (found.start, found.end), found.unit), (sign.start, found.end)
        return Neg(number, at) if sign.text == "-" else replace(number, at=at)

    def expression(self, binding: int) -> Expr:
        """Return the longest expression whose operators bind tighter than `binding`."""
        left = self.prefix()
        while (strength := _BINDING.get(self.current.text, 0)) > binding:
            if strength == _POWER:
                self.advance()
                right = self.nested(_POWER - 1)
                left = Power(left, right, (left.at[0], right.at[1]))
            else:
                left = self.chain(left, strength)
        return left

    def nested(self, binding: int, alone: bool = False) -> Expr:
        """Return an expression one level deeper; raises ExpressionError beyond the limit."""
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise _error("E104", f"the expression is nested more than {MAX_NESTING} deep", self.current)
        inner = self.standing_alone() if alone else self.expression(binding)
        self.depth -= 1
        return inner

    def chain(self, first: Expr, strength: int) -> Expr:
        """Return the n-ary sum or product that starts with `first`."""
        operands, signs = [first], [1]
        while _BINDING.get(self.current.text) == strength:
            signs.append(1 if self.advance().text in "+*" else -1)
            operands.append(self.expression(strength))
        at = (first.at[0], operands[-1].at[1])
        return (Sum if strength == _SUM else Product)(tuple(operands), tuple(signs), at)

    def prefix(self) -> Expr:
        token = self.current
        if token.kind is Kind.NUMBER:
            self.advance()
            return Number(token.number, (token.start, token.end))
        if token.kind is Kind.NAME:
            self.advance()
            return self.call(token) if self.current.text == "(" else self.name(token)
        if token.text in ("-", "+"):
            self.advance()
            operand = self.nested(_UNARY)
            at = (token.start, operand.at[1])
            return Neg(operand, at) if token.text == "-" else replace(operand, at=at)
        if token.text == "(":
            self.open.append(self.advance())
            inner = self.nested(0)
            return replace(inner, at=(token.start, self.close()))
        if token.text == "[":
            self.open.append(self.advance())
            items, end = self.items("]")
            return Vector(items, (token.start, end))
        self.refuse_foreign_operator()
        raise self.missing("an operand")

    def name(self, token: Token) -> Expr:
        if token.text in FUNCTIONS:
            hint = f"write {token.text}(...)"
            raise _error("E115", f"the function '{token.text}' has no arguments", token, hint)
        return Name(token.text, (token.start, token.end))

    def call(self, token: Token) -> Expr:
        if token.text not in self.functions:
            count = hints.argument_count(each.text for each in self.tokens[self.position :])
            hint = hints.function_hint(token.text, FUNCTIONS, count)
            raise _error("E114", f"unknown function '{token.text}'", token, hint)
        self.open.append(self.advance())
        args, end = self.items(")")
        least, most = self.functions[token.text]
        if len(args) < least or (most is not None and len(args) > most):
            wanted = f"{least} argument{'s' if least > 1 else ''}"
            wanted += "" if most is not None else " or more"
            message = f"'{token.text}' takes {wanted} but has {len(args)}"
            raise ExpressionError("E115", message, token.start, end, hints.signature(token.text, len(args)))
        return Call(token.text, args, (token.start, end))

    def items(self, closing: str) -> tuple[tuple[Expr, ...], int]:
        """Return the expressions up to a closing bracket, and where it ends."""
        items: list[Expr] = []
        if self.current.text != closing:
            items.append(self.nested(0, alone=True))
            while self.current.text == ",":
                self.advance()
                items.append(self.nested(0, alone=True))
        return tuple(items), self.close(closing)

    def close(self, closing: str = ")") -> int:
        """Consume the bracket that closes the innermost open one and return where it ends."""
        token = self.current
        if token.text != closing:
            self.refuse_foreign_operator()
            self.refuse_adjacent()
            if token.text == ",":
                raise _error("E112", "',' is only used between the arguments of a function", token)
            opening = self.open[-1]
            place = f"at character {opening.start + 1} of the expression"
            message = f"expected '{closing}' for the '{opening.text}' {place}"
            raise _error("E113", message, token)
        self.open.pop()
        return self.advance().end

    def missing(self, what: str) -> ExpressionError:
        token = self.current
        before = f" after '{self.tokens[self.position - 1].text}'" if self.position else ""
        if token.kind is Kind.END:
            return _error("E112", f"the expression ends where {what} is expected{before}", token)
        return _error("E112", f"expected {what}{before} but found '{token.text}'", token)

    def refuse_foreign_operator(self) -> None:
        """Raise if the current token is an operator of another language."""
        hint = hints.FOREIGN.get(self.current.text)
        if hint:
            raise _error("E117", f"'{self.current.text}' is not an operator here", self.current, hint)

    def refuse_adjacent(self) -> None:
        """Raise if an operand stands where an operator is expected."""
        token, before = self.current, self.tokens[self.position - 1]
        if token.kind in (Kind.NUMBER, Kind.NAME) or token.text == "(":
            for word in (token, before):
                if word.text in hints.KEYWORDS:
                    raise _error(
                        "E117", f"'{word.text}' is not an operator here", word, hints.NO_CONDITIONALS
                    )
            if before.kind is Kind.NUMBER and token.text in hints.UNITS:
                raise _error("E116", f"'{token.text}' after a number", token, hints.unit_hint(token.text))
            hint = f"write '{before.text}*{token.text}' for a product"
            raise _error("E116", f"an operator is missing before '{token.text}'", token, hint)


def _error(code: str, message: str, token: Token, hint: str | None = None) -> ExpressionError:
    return ExpressionError(code, message, token.start, max(token.end, token.start + 1), hint)
