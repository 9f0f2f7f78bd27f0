"""The number system of IEEE single precision: one format for every value and constant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.arith.kernels.blocks import unpack
from cordicc.arith.kernels.reduction import phase_in_turns
from cordicc.arith.numbers.decimals import parse_decimal
from cordicc.arith.numbers.formats import SINGLE, BinaryPoint, NumberFormat, Signal
from cordicc.arith.numbers.operations import EXACT, kept
from cordicc.arith.numbers.slack import slack_of
from cordicc.base.arrays import Bools, Floats, Words

_SIGNIFICAND_BITS = 24
_OVERFLOW_FROM = Fraction(2**25 - 1) * 2**103
_SMALLEST_NORMAL = 2.0**-126


@dataclass(frozen=True, slots=True)
class SingleSystem:
    """Every value is an IEEE single; sums and products are rounded once, to nearest even."""

    operand_bits: int = _SIGNIFICAND_BITS

    def format(self, spec: BinaryPoint | None) -> NumberFormat:
        """Return single precision.  Raises ValueError if a plan states another format."""
        if spec is not None:
            raise ValueError("values of IEEE single have no format of their own")
        return SINGLE

    def constant_text(self, number: Fraction) -> str:
        """Return the shortest text, such as `0.1` or `1e-20`."""
        return str(_nearest_single(number))

    def constant(self, text: str) -> Signal:
        """Read a decimal text."""
        return Signal(np.asarray(_nearest_single(parse_decimal(text))), SINGLE)

    def calculate(
        self, op: str, params: Mapping[str, Any], operands: Sequence[Signal], result: NumberFormat
    ) -> Words:
        """Execute an operation; sums and products of two 24-bit numbers in 53 bits are as if rounded once."""
        values = [operand.values for operand in operands]
        invalid: Bools = np.isnan(values[0])
        for value in values[1:]:
            invalid = invalid | np.isnan(value)
        if op == "wrap":
            return result.encode_angle(wrapped(values[0]))
        if op == "guard":
            invalid = invalid | ~kept(params["condition"], values[1], slack_of(params).beyond)
        with np.errstate(invalid="ignore", over="ignore", under="ignore"):
            exact = self._exact(op, params, values)
        return result.encode(np.where(invalid, np.nan, exact))

    def _exact(self, op: str, params: Mapping[str, Any], values: list[Floats]) -> Floats:
        if op == "mul":
            return np.asarray(values[0] * values[1])
        if op == "cmul":
            return np.asarray(values[0] * self.constant(params["factor"]).values)
        if op == "shift":
            return np.asarray(np.ldexp(values[0], max(-2000, min(2000, int(params["exponent"])))))
        if op == "sign":
            return np.asarray(np.sign(values[0]))
        if op not in EXACT:
            raise ValueError(f"unknown operation {op!r}")
        return np.asarray(EXACT[op](*values))

    def spec(self) -> dict[str, Any]:
        """Return the plain-data form."""
        return {"kind": "ieee-single"}


def wrapped(angle: Floats) -> Floats:
    """Return an angle in radians modulo 2 pi, in [-pi, pi] as float64.

    The number nearest to pi, which is beyond it, is pi: it is twice the number nearest to pi/2, say.  Others
    are exact but for 2^-59 rad up to 2^24 rad (2 pi in two parts, the product with the first exact), and for
    2^-51 rad beyond (phase modulo 2^64).
    """
    with np.errstate(invalid="ignore"):
        turns = np.rint(angle / math.tau)
        near = np.abs(angle) <= 2.0**24
        turns = np.where(near & (np.abs(angle) != NEAREST_PI), turns, 0.0)
        result = np.clip((angle - turns * TAU_HEAD) - turns * TAU_TAIL, -math.pi, math.pi)
    far = ~near & np.isfinite(angle)
    if far.any():
        result = result.copy()
        result[far] = phase_in_turns(unpack(angle[far], _SIGNIFICAND_BITS)) * math.tau
    return np.asarray(result)


NEAREST_PI = float(np.float32(math.pi))
"""The single-precision number nearest to pi, which is beyond it."""

TAU_HEAD = math.floor(math.tau * 2**26) / 2**26
TAU_TAIL = (math.tau - TAU_HEAD) + 2.4492935982947064e-16  # 2 pi - float(2 pi), correctly rounded


def _nearest_single(number: Fraction) -> np.float32:
    magnitude = abs(number)
    if magnitude >= _OVERFLOW_FROM:
        raise OverflowError("the constant is outside IEEE single")
    if magnitude == 0:
        return np.float32(0)
    exponent = magnitude.numerator.bit_length() - magnitude.denominator.bit_length()
    if magnitude < Fraction(2) ** exponent:
        exponent -= 1
    mantissa = round(magnitude / Fraction(2) ** (exponent - 23))
    value = math.ldexp(mantissa, exponent - 23)
    if value < _SMALLEST_NORMAL:
        raise OverflowError("the constant is too small for IEEE single, whose least normal number is 1.2e-38")
    return np.float32(-value if number < 0 else value)
