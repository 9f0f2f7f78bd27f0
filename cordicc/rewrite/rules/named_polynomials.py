"""Polynomials in the names of the problem, for sentences that say what rewriting did.

Formulas stand between backticks in a sentence, written as in a problem file.
"""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import Poly, rational
from cordicc.rewrite.exact.values import Store

_TERMS = 6


def name_of(store: Store, value: Value) -> str:
    """Return an input's name, else that of the equation which asked for the value."""
    node = store.node(value)
    return node.name if node.op == "input" else node.origin or "constant"


def text_of(store: Store, poly: Poly) -> str:
    """Return a polynomial of `Field.display` as text; long ones are cut short."""
    terms = []
    for powers, factor in list(poly.terms())[:_TERMS]:
        number = rational(factor)
        parts = [
            _generator(store, i) + (f"**{power}" if power > 1 else "")
            for i, power in enumerate(powers)
            if power
        ]
        size = _number(abs(number))
        shown = [size] if size != "1" or not parts else []
        terms.append(("-" if number < 0 else "+") + " " + "*".join([*shown, *parts]))
    text = " ".join(terms).removeprefix("+ ") or "0"
    text = "-" + text.removeprefix("- ") if text.startswith("- ") else text
    return text + (" + ..." if len(poly) > _TERMS else "")


def _number(number: Fraction) -> str:
    return str(number.numerator) if number.denominator == 1 else f"{float(number):.6g}"


def _generator(store: Store, index: int) -> str:
    if index in store.rotors.turned:
        angle, m, result = store.rotors.turned[index]
        return f"{('cos', 'sin')[result]}{'h' if m == -1 else ''}({name_of(store, angle)})"
    if index in store.field.radicands:
        radicand = store.field.radicands[index]
        if radicand.is_constant():
            return f"sqrt({_number(rational(radicand.leading_coefficient()))})"
        return f"w{index}"
    value = store.generator_value(index)
    return _number(value) if isinstance(value, Fraction) else "?" if value is None else name_of(store, value)
