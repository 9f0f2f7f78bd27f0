"""Proofs by SymPy that a value is zero, within budgets of size.

SymPy has no limits of its own: a tower of powers, the sine of a million times an angle or a sum of many
fractions exhausts time and memory.  So the size of what a step can make is bounded from above before the
step is taken.  The bounds count terms, bits and operations, so that the same problem has the same outcome
everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from cordicc.ir.graph import Node

MAX_NODES = 400
"""Operations on the way to the value."""

MAX_TREE = 4_000
"""Operations of its expression, in which shared parts are written out each time."""

MAX_TERMS = 2_000
"""Terms of an expression that is multiplied out."""

MAX_BITS = 20_000
"""Of a number."""

MAX_MULTIPLE = 64
"""Of an angle whose sine or cosine is written as a polynomial in those of the angle itself."""

_NOISE = Fraction(1, 1 << 150)  # constants are rounded to 256 bits


class ZeroProof(Enum):
    """What came of a proof."""

    ZERO = "zero"
    OPEN = "not proven"
    TOO_LARGE = "given up: too large"


class _TooLarge(Exception):
    """A step would exceed a budget."""


def verdict(nodes: Sequence[Node], order: Sequence[int]) -> ZeroProof:
    """Return whether the last of some nodes, which are in order, is proven to be zero where it exists."""
    try:
        _check_size(nodes, order)
        import sympy  # slow to import, and rarely needed

        found = _vanishes(sympy, _to_sympy(sympy, nodes, order))
    except (_TooLarge, RecursionError):
        return ZeroProof.TOO_LARGE
    return ZeroProof.ZERO if found else ZeroProof.OPEN


# -- the size of an expression before it is made --------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Size:
    """Bounds of an expression: its operations, its terms when multiplied out, the bits of their factors."""

    tree: int = 1
    terms: int = 1
    bits: int = 0

    def checked(self) -> _Size:
        """Return it; raises _TooLarge beyond the budgets."""
        if self.tree > MAX_TREE or self.terms > MAX_TERMS or self.bits > MAX_BITS:
            raise _TooLarge
        return self


def _check_size(nodes: Sequence[Node], order: Sequence[int]) -> None:
    """Raise _TooLarge if an expression on the way to the last node is too large."""
    if len(order) > MAX_NODES:
        raise _TooLarge
    sizes: dict[int, _Size] = {}
    for index in order:
        node = nodes[index]
        sizes[index] = _size(node, [sizes[v.node] for v in node.operands]).checked()


def _size(node: Node, parts: Sequence[_Size]) -> _Size:
    match node.op:
        case "const":
            number = node.number
            return _Size(bits=number.numerator.bit_length() + number.denominator.bit_length())
        case "add" | "sub":
            return _sum(parts)
        case "mul" | "div":
            return _product(parts)
        case "pow":
            return _power(parts[0], math.ceil(abs(node.exponent)))
        case "hypot":
            return _sum([_power(part, 2) for part in parts])
        case "neg" | "guard":
            return parts[0]
        case op if op in _DIRECT:
            # Arguments are multiplied out as well: their sizes count on.
            return _Size(parts[0].tree + 1, parts[0].terms, parts[0].bits)
    return _Size()


def _sum(parts: Sequence[_Size]) -> _Size:
    return _Size(
        1 + sum(p.tree for p in parts),
        sum(p.terms for p in parts),
        1 + sum(p.bits for p in parts),
    )


def _product(parts: Sequence[_Size]) -> _Size:
    terms = math.prod(p.terms for p in parts)
    bits = sum(p.bits for p in parts) + terms.bit_length()
    return _Size(1 + sum(p.tree for p in parts), terms, bits)


def _power(base: _Size, exponent: int) -> _Size:
    terms = base.terms**exponent if base.terms > 1 else 1
    bits = exponent * (base.bits + base.terms.bit_length())
    return _Size(1 + base.tree, terms, bits)


_FUNCTIONS = "sqrt sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log"
_DIRECT = frozenset(_FUNCTIONS.split())
"""Operations that SymPy has under the same name."""


def _to_sympy(sympy: Any, nodes: Sequence[Node], order: Sequence[int]) -> Any:
    """Return the last node as a SymPy expression; operations without algebra become symbols."""
    made: dict[int, Any] = {}
    for index in order:
        node = nodes[index]
        args = [made[v.node] for v in node.operands]
        match node.op:
            case "const":
                result = _rational(sympy, node.number)
            case "add":
                result = args[0] + args[1]
            case "sub":
                result = args[0] - args[1]
            case "mul":
                result = args[0] * args[1]
            case "div":
                result = args[0] / args[1]
            case "neg":
                result = -args[0]
            case "pow":
                result = args[0] ** _rational(sympy, node.exponent)
            case "guard":
                result = args[0]
            case "hypot":
                result = sympy.sqrt(args[0] ** 2 + args[1] ** 2)
            case op if op in _DIRECT:
                result = getattr(sympy, op)(args[0])
            case _:
                result = sympy.Dummy(f"v{index}", real=True)
        if result.has(sympy.nan, sympy.zoo, sympy.oo):
            result = sympy.Dummy(f"v{index}", real=True)
        made[index] = result
    return made[order[-1]]


def _rational(sympy: Any, number: Fraction) -> Any:
    return sympy.Rational(number.numerator, number.denominator)


# -- the steps of a proof -------------------------------------------------------------------------


def _vanishes(sympy: Any, expr: Any) -> bool:
    """Return whether an expression is multiplied out to nothing, with angles or fractions taken apart.

    Raises _TooLarge before a step that could make too many terms.
    """
    expr = _flat(sympy, sympy.expand(expr))
    if _is_nothing(expr):
        return True
    _require(_terms(expr, _of_angles(sympy)))
    expr = _flat(sympy, sympy.expand(sympy.expand_trig(expr)))
    if _is_nothing(expr):
        return True
    _require(_fraction(sympy, expr).terms)
    numerator = sympy.together(expr).as_numer_denom()[0]
    _require(_terms(numerator, lambda atom: 1))
    return _is_nothing(_flat(sympy, sympy.expand(numerator)))


def _is_nothing(expr: Any) -> bool:
    return all(abs(k) < _NOISE for k in expr.as_coefficients_dict().values())


def _require(terms: int) -> None:
    if terms > MAX_TERMS:
        raise _TooLarge


Atoms = Callable[[Any], int]


def _terms(expr: Any, atom: Atoms) -> int:
    """Return a bound of the terms of an expression multiplied out, `atom` telling those of other parts."""
    if expr.is_Add:
        return min(sum(_terms(part, atom) for part in expr.args), MAX_TERMS + 1)
    if expr.is_Mul:
        return _capped(_terms(part, atom) for part in expr.args)
    if expr.is_Pow and expr.exp.is_Integer and expr.exp > 0:
        base = _terms(expr.base, atom)
        return 1 if base == 1 else _capped([base] * min(int(expr.exp), MAX_TERMS))
    return atom(expr)


def _capped(factors: Any) -> int:
    """Return a product, no more than one above the budget."""
    total = 1
    for factor in factors:
        total = min(total * factor, MAX_TERMS + 1)
    return total


def _of_angles(sympy: Any) -> Atoms:
    """Return what bounds the terms of a function of an angle by those of its parts."""
    functions = (sympy.sin, sympy.cos, sympy.tan, sympy.sinh, sympy.cosh, sympy.tanh)

    def atom(expr: Any) -> int:
        if not isinstance(expr, functions):
            return max((_terms(part, atom) for part in expr.args), default=1)
        parts = expr.args[0].args if expr.args[0].is_Add else (expr.args[0],)
        multiples = [part.as_coeff_Mul(rational=True)[0] for part in parts]
        counts = [int(abs(n)) if n.is_Integer else 1 for n in multiples]
        if max(counts) > MAX_MULTIPLE:
            raise _TooLarge
        # Two terms for each sum of two angles, up to n + 1 for the multiple n.
        return _capped(2 * count for count in counts)

    return atom


@dataclass(frozen=True, slots=True)
class _Fraction:
    """Bounds of a fraction: terms of its numerator, and the powers of what its denominator is made of."""

    terms: int
    powers: Mapping[Any, int]
    sizes: Mapping[Any, int]

    def over(self, powers: Mapping[Any, int], sizes: Mapping[Any, int]) -> int:
        """Return the terms of the numerator over a common denominator."""
        factors = [self.terms]
        for base, power in powers.items():
            if sizes[base] > 1:
                factors += [sizes[base]] * min(power - self.powers.get(base, 0), MAX_TERMS)
        return _capped(factors)


def _fraction(sympy: Any, expr: Any) -> _Fraction:
    """Return bounds of an expression as one fraction."""
    if expr.is_Add or expr.is_Mul:
        parts = [_fraction(sympy, part) for part in expr.args]
        sizes = {base: size for part in parts for base, size in part.sizes.items()}
        powers: dict[Any, int] = {}
        for part in parts:
            for base, power in part.powers.items():
                powers[base] = max(powers.get(base, 0), power) if expr.is_Add else powers.get(base, 0) + power
        if expr.is_Mul:
            return _Fraction(_capped(part.terms for part in parts), powers, sizes)
        return _Fraction(min(sum(p.over(powers, sizes) for p in parts), MAX_TERMS + 1), powers, sizes)
    if expr.is_Pow and expr.exp.is_Rational:
        base, exponent = _fraction(sympy, expr.base), abs(expr.exp)
        times = min(math.ceil(exponent), MAX_TERMS)
        inner = {each: power * times for each, power in base.powers.items()}
        if expr.exp > 0:
            terms = 1 if base.terms == 1 else _capped([base.terms] * times)
            return _Fraction(terms, inner, base.sizes)
        # The base's own denominator comes to stand above.
        above = _Fraction(1, {}, {}).over(inner, base.sizes)
        return _Fraction(above, {expr.base: times}, {expr.base: base.terms})
    return _Fraction(1, {}, {})


def _flat(sympy: Any, expr: Any) -> Any:
    """Return the expression with sin**2 and sinh**2 replaced by the cosines, multiplied out."""
    signs = {sympy.sin: -1, sympy.sinh: 1}

    def is_high(e: Any) -> bool:
        return bool(e.is_Pow and e.base.func in signs and e.exp.is_Integer and e.exp > 1)

    def lowered(base: Any, exponent: Any) -> Any:
        sign = signs[base.func]
        cosine = (sympy.cos if sign < 0 else sympy.cosh)(base.args[0])
        half, rest = divmod(int(exponent), 2)
        return (sign * (cosine**2 - 1)) ** half * base**rest

    flat = expr.replace(is_high, lambda e: lowered(e.base, e.exp))
    _require(_terms(flat, lambda atom: 1))
    return sympy.expand(flat)
