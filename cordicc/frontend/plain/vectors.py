"""Vectors in equations: brackets, sums, dot, cross, norm and rotate, expanded by components."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import (
    VECTOR_FUNCTIONS,
    Call,
    Expr,
    Name,
    Neg,
    Number,
    Power,
    Product,
    Sum,
    Vector,
    children,
    postorder,
)
from cordicc.frontend.plain.expansion import Expansion
from cordicc.frontend.trees import rebuilt

AXES = ("x", "y", "z")
FRAME = 0
"""The dimension of a frame: its entries have names, but it is no vector."""

Expanded = Expr | tuple[Expr, ...]


def uses_vectors(expr: Expr, vectors: Mapping[str, int]) -> bool:
    """Return whether an expression has anything of vectors in it."""
    return any(
        isinstance(part, Vector)
        or (isinstance(part, Call) and part.function in VECTOR_FUNCTIONS)
        or (isinstance(part, Name) and part.name in vectors)
        for part in postorder(expr)
    )


def component_names(name: str, dimension: int) -> list[str]:
    """Return the names of the components of a vector."""
    return [f"{name}_{axis}" for axis in AXES[:dimension]]


class Vectors:
    """Expands expressions with vectors; `vectors` has the dimensions of those that are defined.

    Methods raise ExpressionError with places in the file.
    """

    def __init__(self, vectors: Mapping[str, int], expansion: Expansion) -> None:
        self.vectors = vectors
        self.expansion = expansion

    def scalar(self, expr: Expr) -> Expr:
        """Return the plain expression of a number."""
        found = self.expand(expr)
        if isinstance(found, tuple):
            raise self._not_a_number(expr)
        return found

    def vector(self, expr: Expr) -> tuple[Expr, ...]:
        """Return the components of a vector."""
        found = self.expand(expr)
        if not isinstance(found, tuple):
            raise _mismatch(expr, "a vector is wanted here", "write [x, y] or [x, y, z]")
        return found

    def expand(self, expr: Expr) -> Expanded:
        """Return the plain expression of a number, or those of a vector's components."""
        found: dict[int, Expanded] = {}
        for part in postorder(expr):
            found[id(part)] = self._one(part, [found[id(child)] for child in children(part)])
        return found[id(expr)]

    def _one(self, expr: Expr, parts: list[Expanded]) -> Expanded:
        scalars = [part for part in parts if not isinstance(part, tuple)]
        match expr:
            case Name(name) if name in self.vectors:
                return self._named(expr)
            case Vector():
                if len(scalars) < len(parts):
                    raise _mismatch(expr, "a component of a vector must be a number")
                if len(parts) not in (2, 3):
                    hint = "group with parentheses ( )" if len(parts) == 1 else None
                    raise _mismatch(expr, f"a vector has 2 or 3 components, not {len(parts)}", hint)
                return tuple(self.expansion.plain(part) for part in scalars)
            case Call(function) if function in VECTOR_FUNCTIONS:
                return self._call(expr, parts)
            case _ if len(scalars) == len(parts):
                return rebuilt(expr, scalars)
            case Neg():
                return tuple(self.expansion.negative(c) for part in parts for c in _components(part))
            case Sum(terms, signs):
                total = parts[0]
                for term, part, sign in list(zip(terms, parts, signs, strict=True))[1:]:
                    self._check_alike(terms[0], parts[0], term, part)
                    pairs = zip(_components(total), _components(part), strict=True)
                    total = tuple(self.expansion.plus(a, b, sign) for a, b in pairs)
                return total
            case Product():
                return self._product(expr, parts)
            case Power():
                raise _mismatch(expr, "a vector has no power", "dot(v, v) is the square of its length")
            case _:
                both = zip(children(expr), parts, strict=True)
                raise self._not_a_number(next(child for child, part in both if isinstance(part, tuple)))

    def _named(self, name: Name) -> tuple[Expr, ...]:
        dimension = self.vectors[name.name]
        if dimension == FRAME:
            hint = f"its entries are {name.name}_px, {name.name}_r11, ..."
            raise _mismatch(name, f"'{name.name}' is a frame, not a number or vector", hint)
        return tuple(Name(component, name.at) for component in component_names(name.name, dimension))

    def _product(self, expr: Product, parts: list[Expanded]) -> Expanded:
        """Return the product of the one vector with numbers."""
        at = [i for i, part in enumerate(parts) if isinstance(part, tuple)]
        if len(at) > 1:
            hint = "write dot(u, v) or cross(u, v)"
            raise _mismatch(expr, "a product of vectors with '*' or '/' has no meaning", hint)
        if expr.signs[at[0]] < 0:
            raise _mismatch(expr.factors[at[0]], "a division by a vector")
        make = self.expansion
        numbers = [make.plain(part) for part in parts if not isinstance(part, tuple)]
        signs = [sign for i, sign in enumerate(expr.signs) if i != at[0]]
        over = sorted(zip(numbers, signs, strict=True), key=lambda pair: -pair[1])
        if len(over) > 1:
            numbers, signs = [n for n, _ in over], [s for _, s in over]
            if signs[0] < 0:
                numbers, signs = [Number(Fraction(1), expr.at), *numbers], [1, *signs]
            number, sign = make.share(Product(tuple(numbers), tuple(signs), expr.at)), 1
        else:
            number, sign = make.share(numbers[0]), signs[0]
        if sign < 0:
            return tuple(Product((c, number), (1, -1), expr.at) for c in _components(parts[at[0]]))
        return tuple(make.times(number, c) for c in _components(parts[at[0]]))

    def _call(self, expr: Call, parts: list[Expanded]) -> Expanded:
        args, make = expr.args, self.expansion
        if expr.function == "vector":
            return self._one(Vector(args, expr.at), parts)
        if expr.function == "rotate":
            return self._rotate(expr, parts)
        for arg, part in zip(args, parts, strict=True):
            if not isinstance(part, tuple):
                hint = f"{expr.function} takes vectors such as [x, y, z]"
                raise _mismatch(arg, "a vector is wanted here", hint)
        if expr.function == "norm":
            components = tuple(make.share(c) for c in _components(parts[0]))
            if len(components) == 2:
                return Call("hypot", components, expr.at)
            return Call("sqrt", (self._dot(components, components, expr),), expr.at)
        self._check_alike(args[0], parts[0], args[1], parts[1])
        u, v = (tuple(make.share(c) for c in _components(part)) for part in parts)
        if expr.function == "dot":
            return self._dot(u, v, expr)
        pairs = [(0, 1)] if len(u) == 2 else [(1, 2), (2, 0), (0, 1)]
        found = tuple(make.plus(make.times(u[i], v[j]), make.times(u[j], v[i]), -1) for i, j in pairs)
        return found[0] if len(found) == 1 else found

    def _dot(self, u: tuple[Expr, ...], v: tuple[Expr, ...], expr: Expr) -> Expr:
        make = self.expansion
        total: Expr = Number(Fraction(0), expr.at)
        for a, b in zip(u, v, strict=True):
            square = a == b and not isinstance(a, Number)
            two = Number(Fraction(2), expr.at)
            total = make.plus(total, Power(a, two, expr.at) if square else make.times(a, b))
        return total

    def _rotate(self, expr: Call, parts: list[Expanded]) -> tuple[Expr, ...]:
        """Return a vector turned right-handedly about an axis, or in the plane."""
        made, form = parts[0], "write rotate(v, axis, angle), axis x, y or z; in the plane rotate(v, angle)"
        if not isinstance(made, tuple):
            raise _mismatch(expr.args[0], "a vector is wanted here", form)
        if len(made) != len(expr.args):
            message = f"a vector of {len(made)} components is rotated with {len(made)} arguments"
            raise ExpressionError("E115", f"{message}, not {len(expr.args)}", *expr.at, form)
        angle = parts[-1]
        if isinstance(angle, tuple):
            raise self._not_a_number(expr.args[-1])
        first, second = 0, 1
        if len(made) == 3:
            axis = expr.args[1]
            if not isinstance(axis, Name) or axis.name not in AXES:
                raise _mismatch(axis, "the axis of a rotation must be x, y or z", form)
            first = (AXES.index(axis.name) + 1) % 3
            second = (first + 1) % 3
        turned = list(made)
        turned[first], turned[second] = self.expansion.turn(
            made[first], made[second], self.expansion.angle(angle)
        )
        return tuple(turned)

    def _check_alike(self, one: Expr, first: Expanded, other: Expr, second: Expanded) -> None:
        if isinstance(first, tuple) != isinstance(second, tuple):
            raise _mismatch(other, "a number and a vector in one operation", "vectors go with vectors")
        if len(_components(first)) != len(_components(second)):
            sizes = f"{len(_components(first))} and {len(_components(second))}"
            raise _mismatch(other, f"vectors of {sizes} components in one operation")

    def _not_a_number(self, expr: Expr) -> ExpressionError:
        hint = "write one of its components, dot(u, v) or norm(v)"
        if isinstance(expr, Name) and self.vectors.get(expr.name):
            shown = ", ".join(component_names(expr.name, self.vectors[expr.name]))
            hint = f"its components are {shown}"
        what = f"'{expr.name}' is a vector" if isinstance(expr, Name) else "this is a vector"
        return _mismatch(expr, f"{what}; a number is wanted here", hint)


def _components(part: Expanded) -> tuple[Expr, ...]:
    return part if isinstance(part, tuple) else (part,)


def _mismatch(expr: Expr, message: str, hint: str | None = None) -> ExpressionError:
    return ExpressionError("E310", message, *expr.at, hint)
