"""Formulas as MathML Core, which browsers show without scripts, each with a plain text beside it.

A formula is put together from the leaves up; brackets come from how tightly its outermost operator binds.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from fractions import Fraction

from cordicc.backends.escaping import quoted

SUM, SIGNED, PRODUCT, POWER, ATOM = 10, 15, 20, 30, 40
"""How tightly the outermost operator binds; what binds less than its place asks for gets brackets."""

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η",
    "theta": "θ", "iota": "ι", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω",
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ",
    "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
FUNCTION_NAMES = {
    "asin": "arcsin", "acos": "arccos", "atan": "arctan", "asinh": "arsinh", "acosh": "arcosh",
    "atanh": "artanh", "log": "ln", "sign": "sgn",
}  # fmt: skip
RELATION_SIGNS = {"=": "=", "<": "&lt;", ">": "&gt;", "<=": "≤", ">=": "≥"}

_APPLY = "<mo>&#x2061;</mo>"
_TIMES = "<mo>&#x2062;</mo>"
_DOT = '<mo lspace="0.15em" rspace="0.15em">⋅</mo>'
_THIN = '<mspace width="0.17em"/>'
_SINGLE = ("letter", "tag")
"""The looks of what a function takes without brackets."""

_LONGEST_NAME = 40
_MOST_DIGITS = 12


@dataclass(frozen=True, slots=True)
class Formula:
    """A formula: MathML, the same as text, how its outermost operator binds, and what it looks like.

    `look` is `number`, `letter` (one sign, perhaps with an index), `tag` (of an operation), `word`, `call`
    (a function without brackets around its argument) or empty.
    """

    markup: str
    text: str
    binding: int = ATOM
    look: str = ""
    negated: Formula | None = None
    """What stands after the minus sign, if this is a negation."""
    parts: tuple[str, str] = ("", "")
    """Function and argument of a call; sign and index of a letter that has one."""

    def html(self, *, block: bool = False) -> str:
        """Return the formula as a `math` element."""
        display = ' display="block"' if block else ""
        return f'<math{display} alttext="{quoted(self.text)}">{self.markup}</math>'

    def within(self, binding: int) -> Formula:
        """Return the formula, in brackets if it binds less tightly than that."""
        if self.binding >= binding:
            return self
        return Formula(_fenced(self.markup), f"({self.text})")

    @property
    def is_zero(self) -> bool:
        """Whether this is the number 0."""
        return self.look == "number" and self.text == "0"

    @property
    def is_one(self) -> bool:
        """Whether this is the number 1."""
        return self.look == "number" and self.text == "1"


def _row(markup: str) -> str:
    return f"<mrow>{markup}</mrow>"


def _fenced(markup: str, left: str = "(", right: str = ")") -> str:
    return _row(f"<mo>{left}</mo>{markup}<mo>{right}</mo>")


def name(text: str) -> Formula:
    """Return a name: Greek words as letters, what follows the first letter as its index."""
    shown = text if len(text) <= _LONGEST_NAME else text[:_LONGEST_NAME] + "…"
    if shown in GREEK:
        return Formula(f"<mi>{GREEK[shown]}</mi>", text, look="letter")
    head, _, tail = shown.partition("_")
    letters = re.match(r"[A-Za-z]+", head)
    base = letters[0] if letters else ""
    rest = head[len(base) :]
    if len(base) == 2 and base[1] in "xyz" and not rest:
        base, rest = base[0], base[1]
    index = ",".join(part for part in (rest, tail.strip("_").replace("_", ",")) if part)
    if (len(base) == 1 or base in GREEK) and index:
        return _with_index(GREEK.get(base, base), index, text)
    return Formula(f"<mi>{quoted(shown)}</mi>", text, look="letter" if len(shown) == 1 else "word")


def indexed(base: str, index: str) -> Formula:
    """Return the sign of an operation, with the name of its result as an index if there is one."""
    if not index:
        return Formula(f"<mi>{quoted(base)}</mi>", base, look="tag")
    return replace(_with_index(base, index, f"{base}.{index}"), look="tag")


def _with_index(sign: str, index: str, text: str) -> Formula:
    parts = (f"<mi>{quoted(sign)}</mi>", f"<mtext>{quoted(index)}</mtext>")
    return Formula(f"<msub>{parts[0]}{parts[1]}</msub>", text, look="letter", parts=parts)


def number(value: Fraction | int | str) -> Formula:
    """Return a number, exactly where that is short; text that is not a number stays as it is."""
    try:
        return _number(Fraction(value))
    except (ValueError, ZeroDivisionError):
        return Formula(f"<mtext>{quoted(str(value))}</mtext>", str(value), look="word")


def _number(value: Fraction) -> Formula:
    if value < 0:
        return negative(_number(-value))
    with localcontext() as context:
        context.prec = _MOST_DIGITS
        digits = Decimal(value.numerator) / Decimal(value.denominator)
    if Fraction(digits) != value and value.denominator < 1000 > value.numerator:
        return quotient(_number(Fraction(value.numerator)), _number(Fraction(value.denominator)))
    places = digits.adjusted()
    if digits and not -5 < places < _MOST_DIGITS:
        mantissa = f"{digits.scaleb(-places).normalize():f}"
        power = str(places).replace("-", "−")
        markup = f"<mn>{mantissa}</mn><mo>×</mo><msup><mn>10</mn><mn>{power}</mn></msup>"
        return Formula(_row(markup), f"{mantissa}e{places}", PRODUCT, "number")
    text = f"{digits.normalize():f}"
    return Formula(f"<mn>{text}</mn>", text, look="number")


def quantity(value: Fraction, unit: str) -> Formula:
    """Return a number with its unit."""
    made = _number(value)
    sign = "°" if unit == "deg" else f"\u00a0{unit}"
    return Formula(_row(f"{made.markup}<mtext>{sign}</mtext>"), f"{made.text} {unit}", PRODUCT)


def negative(operand: Formula) -> Formula:
    """Return -operand."""
    inner = operand.within(PRODUCT)
    return Formula(_row(f"<mo>−</mo>{inner.markup}"), f"-{inner.text}", SIGNED, negated=inner)


def total(terms: Sequence[Formula], signs: Sequence[int]) -> Formula:
    """Return a sum; `signs` has +1 or -1 for each term."""
    markup, text = "", ""
    for term, sign in zip(terms, signs, strict=True):
        if not text:
            first = negative(term) if sign < 0 else term
            markup, text = first.markup, first.text
            continue
        if term.negated is not None:  # + -a is - a
            term, sign = term.negated, -sign
        inner = term.within(SUM if sign > 0 and not term.text.startswith("-") else SIGNED)
        markup += f"<mo>{'+' if sign > 0 else '−'}</mo>{inner.markup}"
        text += f" {'+' if sign > 0 else '-'} {inner.text}"
    return first if len(terms) == 1 else Formula(_row(markup), text, SUM)


def product(factors: Sequence[Formula], signs: Sequence[int] = ()) -> Formula:
    """Return a product; a factor with the sign -1 divides all before it."""
    result: list[Formula] = []
    for factor, sign in zip(factors, signs or [1] * len(factors), strict=True):
        result = [quotient(_times(result), factor)] if sign < 0 else [*result, factor]
    return _times(result)


def _times(factors: Sequence[Formula]) -> Formula:
    if len(factors) == 1:
        return factors[0]
    if factors[0].negated is not None:  # (-a) b is -(a b)
        return negative(_times([factors[0].negated, *factors[1:]]))
    markup, text = "", ""
    for before, factor in zip([None, *factors], factors, strict=False):
        inner = factor.within(PRODUCT if before is None else POWER)
        markup += ("" if before is None else _between(before, factor)) + inner.markup
        text += ("" if before is None else "*") + inner.text
    return Formula(_row(markup), text, PRODUCT)


def _between(before: Formula, after: Formula) -> str:
    """Return the sign between two factors: a dot where they would run into one another."""
    if after.look == "number" or not {"word", "tag"}.isdisjoint((before.look, after.look)):
        return _DOT
    if before.look == "call" and after.look != "call":
        return _DOT
    return _TIMES if before.look == "number" and after.look != "call" else _TIMES + _THIN


def quotient(above: Formula, below: Formula) -> Formula:
    """Return a fraction."""
    text = f"{above.within(PRODUCT).text}/{below.within(POWER).text}"
    return Formula(f"<mfrac>{_row(above.markup)}{_row(below.markup)}</mfrac>", text, POWER)


def power(base: Formula, exponent: Formula) -> Formula:
    """Return a power; one of 1/2 as a root."""
    if exponent.text in ("0.5", "1/2"):
        return root(base)
    if base.look == "call":  # cos x squared has its exponent at the function
        function, argument = base.parts
        markup = _row(f"<msup>{function}{exponent.markup}</msup>{_APPLY}{argument}")
        return Formula(markup, f"{base.text}**{exponent.within(ATOM).text}", POWER, "call", parts=base.parts)
    inner = base.within(ATOM)
    if base.look in _SINGLE and base.parts[1] and base.binding == ATOM:
        markup = f"<msubsup>{base.parts[0]}{base.parts[1]}{_row(exponent.markup)}</msubsup>"
    else:
        markup = f"<msup>{_row(inner.markup)}{_row(exponent.markup)}</msup>"
    return Formula(markup, f"{inner.text}**{exponent.within(ATOM).text}", POWER, "letter")


def root(radicand: Formula) -> Formula:
    """Return a square root."""
    return Formula(f"<msqrt>{_row(radicand.markup)}</msqrt>", f"sqrt({radicand.text})")


def call(function: str, arguments: Sequence[Formula]) -> Formula:
    """Return a function of arguments; of a single sign without brackets."""
    text = f"{function}({', '.join(argument.text for argument in arguments)})"
    if function == "sqrt" and len(arguments) == 1:
        return root(arguments[0])
    if function == "abs" and len(arguments) == 1:
        return Formula(_fenced(arguments[0].markup, "|", "|"), text)
    sign = f"<mi>{quoted(FUNCTION_NAMES.get(function, function))}</mi>"
    if len(arguments) == 1 and arguments[0].look in _SINGLE and arguments[0].binding == ATOM:
        parts = (sign, f"{_THIN}{arguments[0].markup}")
        return Formula(_row(f"{sign}{_APPLY}{parts[1]}"), text, POWER, "call", parts=parts)
    listed = "<mo>,</mo>".join(argument.markup for argument in arguments)
    return Formula(_row(f"{sign}{_APPLY}{_fenced(listed)}"), text)


def vector(items: Sequence[Formula]) -> Formula:
    """Return a vector by its components."""
    listed = "<mo>,</mo>".join(item.markup for item in items)
    return Formula(_fenced(listed, "[", "]"), f"[{', '.join(item.text for item in items)}]")


def relation(left: Formula, sign: str, right: Formula) -> Formula:
    """Return `left sign right`, sign one of = < > <= >=."""
    markup = _row(f"{left.markup}<mo>{RELATION_SIGNS[sign]}</mo>{right.markup}")
    return Formula(markup, f"{left.text} {sign} {right.text}", 0)


def sequence(parts: Sequence[Formula]) -> Formula:
    """Return formulas and words one after the other."""
    inner = [part.within(SUM) for part in parts]
    return Formula(_row("".join(part.markup for part in inner)), "".join(part.text for part in inner), 0)


def words(text: str) -> Formula:
    """Return words between formulas."""
    shown = text.replace(" ", "\u00a0")  # spaces at the ends would be dropped
    return Formula(f"<mtext>{quoted(shown)}</mtext>", text, look="word")
