"""IEEE single precision in the C model: the language's own float for adders and multipliers.

A sum or product of two singles in double precision, rounded to single, is the single nearest to the exact
one, which is what C's float gives: a product has at most 48 bits, so the double is exact; for a sum
53 >= 2 * 24 + 2 bits make the double rounding harmless, and a sum below the normal range is exact
(S. Figueroa, "When is double rounding innocuous?", SIGNUM Newsletter 30(3), 1995).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cordicc.arith.numbers.floating import NEAREST_PI, TAU_HEAD, TAU_TAIL, SingleSystem
from cordicc.arith.numbers.formats import PI_SLACK, SINGLE, SINGLE_PI, NumberFormat
from cordicc.arith.numbers.slack import slack_of
from cordicc.backends.c.c_arithmetic import KEPT, COperand, limit

_SYMBOLS = {"add": "+", "sub": "-", "mul": "*"}
_EXPONENTS = range(-172, 105)
_FAR_EXPONENTS = range(1, 105)
"""Of numbers beyond 2^24, whose phase is looked up."""


@dataclass(slots=True)
class CSinglePrecision:
    """See `CArithmetic`."""

    system: SingleSystem
    ctype: str = "float"
    needs: dict[str, None] = field(default_factory=dict)
    phases: list[range] = field(default_factory=list)

    def constant(self, text: str) -> COperand:
        """Return a constant of the plan."""
        return COperand(_literal(float(self.system.constant(text).words)), SINGLE, constant=True)

    def invalid(self, format_: NumberFormat) -> str:
        """Return the invalid word."""
        return "NAN"

    def is_valid(self, term: COperand) -> str:
        """Return the condition that a word is valid."""
        return f"{self._use('is_number')}({term.text})"

    def calculate(
        self, op: str, params: Mapping[str, Any], terms: Sequence[COperand], result: NumberFormat
    ) -> str:
        """Return the result of an operation, given that the terms are valid."""
        texts = [term.text for term in terms]
        a = texts[0]
        if op in _SYMBOLS:
            return f"{self._use('in_range')}({a} {_SYMBOLS[op]} {texts[1]})"
        if op == "cmul":
            return f"{self._use('in_range')}({a} * {self.constant(params['factor']).text})"
        if op in ("min", "max"):
            # Of zeros of either sign, the second.
            return f"{a} {'<' if op == 'min' else '>'} {texts[1]} ? {a} : {texts[1]}"
        if op == "flip":
            return f"{texts[1]} >= 0 ? {a} : -{a}"
        if op == "select":
            return f"{a} >= 0 ? {texts[1]} : {texts[2]}"
        if op == "guard":
            test, slack = KEPT[params["condition"]], slack_of(params).beyond
            least = (-slack).hex() if slack else "0"
            return f"{texts[1]} {test} {least} ? {a} : NAN" if test else a
        if op == "shift":
            return f"{self._use('single_scaled', 'times_power')}({a}, {params['exponent']})"
        if op == "neg":
            return f"-{a}"
        if op == "wrap":
            self.phases.append(_FAR_EXPONENTS)
        section, name = {
            "abs": ("single_magnitude", "absolute"),
            "sign": ("single_sign", "sign_of"),
            "wrap": ("single_wrap", "wrap"),
        }[op]
        return f"{self._use(section, name)}({a})"

    def unpack(self, term: COperand) -> str:
        """Return a valid word as an operand of a unit."""
        return f"{self._use('unpack_single', 'unpack')}({term.text})"

    def pack(self, number: str, result: NumberFormat, *, angle: bool) -> str:
        """Return a unit's result as a word."""
        if angle:
            return f"{self._use('pack_single_angle', 'pack_angle')}({number})"
        return f"{self._use('pack_unit_single', 'pack')}({number})"

    def converted(self, term: COperand, result: NumberFormat) -> str:
        """Return the word: there is one format."""
        return term.text

    def encode(self, number: str, result: NumberFormat) -> str:
        """Return the word of a double."""
        return f"{self._use('encode_single', 'encode')}({number})"

    def decode(self, term: COperand) -> str:
        """Return the double that a word stands for."""
        return f"(double){term.text}"

    def exponents(self, format_: NumberFormat) -> range:
        """Return the exponents of operands of 24 bits, those of subnormal numbers included."""
        return _EXPONENTS

    def describe(self, format_: NumberFormat) -> str:
        """Return nothing: there is one format."""
        return ""

    def context(self) -> dict[str, Any]:
        """Return what the templates need to know."""
        return {
            "single_pi": float(SINGLE_PI),
            "nearest_pi": NEAREST_PI,
            "single_limit": limit(math.pi + PI_SLACK),
            "tau": math.tau,
            "tau_head": TAU_HEAD,
            "tau_tail": TAU_TAIL,
        }

    def _use(self, section: str, name: str = "") -> str:
        self.needs[section] = None
        return name or section


def _literal(value: float) -> str:
    text = f"{value.hex()}F" if value else f"{value}F"
    return f"({text})" if text.startswith("-") else text
