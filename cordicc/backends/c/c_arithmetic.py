"""What the number systems of the C model have in common: operands of expressions, and what each can write."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from cordicc.arith.numbers.formats import NumberFormat


@dataclass(frozen=True, slots=True)
class COperand:
    """An operand as a C expression, the format of its words, and its word if it is a constant."""

    text: str
    format: NumberFormat
    constant: bool = False


class CArithmetic(Protocol):
    """Writes the arithmetic of a number system in C.

    `needs` collects the sections used, `phases` the exponents of angles that are reduced to turns.
    """

    ctype: str
    needs: dict[str, None]
    phases: list[range]

    def constant(self, text: str) -> COperand:
        """Return a constant of the plan."""

    def invalid(self, format_: NumberFormat) -> str:
        """Return the invalid word."""

    def is_valid(self, term: COperand) -> str:
        """Return the condition that a word is valid."""

    def calculate(
        self, op: str, params: Mapping[str, Any], terms: Sequence[COperand], result: NumberFormat
    ) -> str:
        """Return the result of an operation, given that the terms are valid."""

    def unpack(self, term: COperand) -> str:
        """Return a valid word as an operand of a unit."""

    def pack(self, number: str, result: NumberFormat, *, angle: bool) -> str:
        """Return a unit's result as a word."""

    def converted(self, term: COperand, result: NumberFormat) -> str:
        """Return a word, valid or not, in another format."""

    def encode(self, number: str, result: NumberFormat) -> str:
        """Return the word of a double."""

    def decode(self, term: COperand) -> str:
        """Return the double that a word stands for."""

    def exponents(self, format_: NumberFormat) -> range:
        """Return the exponents that non-zero operands of a format may have."""

    def describe(self, format_: NumberFormat) -> str:
        """Return a few words on a format."""

    def context(self) -> dict[str, Any]:
        """Return what the templates need to know."""


KEPT = {"any": "", "nonzero": "!=", "nonnegative": ">=", "positive": ">"}
"""The comparison with 0 of each condition of a guard."""


def limit(number: float) -> tuple[int, int]:
    """Return a number as an integer of 53 bits, and how many of them are fraction bits."""
    mantissa, exponent = math.frexp(number)
    return int(math.ldexp(mantissa, 53)), 53 - exponent


def conjunction(conditions: Sequence[str]) -> str:
    """Return C text for all of the conditions, without repetitions; 1 for none."""
    return " && ".join(dict.fromkeys(conditions)) or "1"
