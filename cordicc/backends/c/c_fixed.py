"""Fixed point in the C model: every operation in integers of 64 bits, rounded once."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from cordicc.arith.kernels.shift_sequences import pi_fixed, turn_fixed
from cordicc.arith.numbers.fixed_point import SHIFT_LIMIT, WIDTHS, FixedPoint
from cordicc.arith.numbers.fixed_system import WRAP_GUARD_BITS, FixedSystem, wraps_in_int64
from cordicc.arith.numbers.formats import NumberFormat
from cordicc.arith.numbers.slack import slack_of
from cordicc.backends.c.c_arithmetic import KEPT, COperand, limit
from cordicc.backends.c.c_sections import int64

_MOST_SPREAD = 29
"""Binary places between two words whose sum surely fits 64 bits."""

_LARGEST_COARSE = 16
_MOST_LIFT = 56
_TURN_BITS = WIDTHS.stop - 1


class CannotEmit(Exception):
    """The C model has no form for an operation; the message says which and why."""


@dataclass(slots=True)
class CFixedPoint:
    """See `CArithmetic`."""

    system: FixedSystem
    ctype: str = "int32_t"
    needs: dict[str, None] = field(default_factory=dict)
    phases: list[range] = field(default_factory=list)

    def constant(self, text: str) -> COperand:
        """Return a constant of the plan."""
        word, format_ = self.system.constant(text)
        return COperand(f"({int(word)})" if word < 0 else str(int(word)), format_, constant=True)

    def invalid(self, format_: NumberFormat) -> str:
        """Return the invalid word."""
        return f"INVALID({format_.width_bits})"

    def is_valid(self, term: COperand) -> str:
        """Return the condition that a word is valid."""
        return f"{term.text} != {self.invalid(term.format)}"

    def calculate(
        self, op: str, params: Mapping[str, Any], terms: Sequence[COperand], result: NumberFormat
    ) -> str:
        """Return the result of an operation, given that the terms are valid."""
        to = _fixed(result)
        a, second = terms[0], terms[min(1, len(terms) - 1)]
        if op in ("add", "sub"):
            return self._sum(a, second, to, minus=op == "sub")
        if op in ("mul", "cmul"):
            b = second if op == "mul" else self.constant(params["factor"])
            return self._rounded(f"(int64_t){a.text} * {b.text}", _bits(a) + _bits(b), to)
        if op in ("min", "max"):
            test = self._compared(a, "<" if op == "min" else ">", second)
            return f"{test} ? {self._word(a, to)} : {self._word(second, to)}"
        if op == "select":
            return f"{a.text} >= 0 ? {self._word(second, to)} : {self._word(terms[2], to)}"
        if op == "flip":
            chosen = f"{second.text} >= 0 ? (int64_t){a.text} : -(int64_t){a.text}"
            return self._rounded(chosen, _bits(a), to)
        if op == "guard":
            test = KEPT[params["condition"]]
            slack = math.floor(Fraction(slack_of(params).beyond) * Fraction(2) ** _bits(second))
            least = -min(slack, _fixed(second.format).largest_word)
            kept = f"{second.text} {test} {least} ? {self._word(a, to)} : {self.invalid(to)}"
            return kept if test else self._word(a, to)
        if op == "shift":
            return self._rounded(a.text, _bits(a) - int(params["exponent"]), to)
        if op == "neg":
            return self._rounded(f"-(int64_t){a.text}", _bits(a), to)
        if op == "abs":
            return self._rounded(f"{self._use('magnitude')}({a.text})", _bits(a), to)
        if op == "sign":
            return self._rounded(f"({a.text} > 0) - ({a.text} < 0)", 0, to)
        assert op == "wrap", op
        return self._wrapped(a, to)

    def _word(self, term: COperand, to: FixedPoint) -> str:
        """Return a word rounded to another format."""
        return self._rounded(term.text, _bits(term), to)

    def _rounded(self, number: str, fraction: int, to: FixedPoint) -> str:
        """Return a number of so many fraction bits, below 2^62, rounded once."""
        right = max(-63, min(63, fraction - to.fraction_bits))
        if right == 0:
            return f"{self._use('word')}({number}, {to.width_bits})"
        return f"{self._use('rounded')}({number}, {right}, {to.width_bits})"

    def _sum(self, a: COperand, b: COperand, to: FixedPoint, *, minus: bool) -> str:
        signs = (1, -1 if minus else 1)
        coarse, fine = sorted(zip((a, b), signs, strict=True), key=lambda pair: _bits(pair[0]))
        spread = _bits(fine[0]) - _bits(coarse[0])
        if spread <= _MOST_SPREAD:
            lifted = {
                id(term): f"(int64_t){term.text}"
                + (f" * {int64(1 << lift)}" if (lift := _bits(fine[0]) - _bits(term)) else "")
                for term in (a, b)
            }
            number = f"{lifted[id(a)]} {'-' if minus else '+'} {lifted[id(b)]}"
            return self._rounded(number, _bits(fine[0]), to)
        return self._wide_sum(coarse, fine, to)

    def _wide_sum(self, coarse: tuple[COperand, int], fine: tuple[COperand, int], to: FixedPoint) -> str:
        """Return the rounded sum of words whose binary points lie far apart.

        The finer word is cut off below a quarter of the result's last place and below half of the
        coarser word's, with a sticky bit: no rounding can tell.  A coarse word that is lifted by 30 places
        or more leaves the result's range if it exceeds 16, and one lifted by 57 or more if it is not 0.
        """
        (a, a_sign), (b, b_sign) = coarse, fine
        fraction = min(_bits(b), max(_bits(a) + 1, to.fraction_bits + 2))
        cut = min(63, _bits(b) - fraction)
        lift = fraction - _bits(a)
        low = f"{'-' if b_sign < 0 else ''}(int64_t){b.text}"
        if cut:
            low = f"{self._use('sticky')}({low}, {cut})"
        high = f"{'-' if a_sign < 0 else ''}(int64_t){a.text}"
        if lift > _MOST_SPREAD:
            high = f"{self._use('within')}({high}, {_LARGEST_COARSE})"
        return self._rounded(f"{high} * {int64(1 << min(lift, _MOST_LIFT))} + {low}", fraction, to)

    def _compared(self, a: COperand, test: str, b: COperand) -> str:
        """Compare words; 32 places tell the lesser of any two apart.

        A constant that no word of the other format reaches decides; compilers warn of such comparisons.
        """
        spread = max(-32, min(32, _bits(a) - _bits(b)))
        for constant, lift, other, met in ((b, spread, a, "<"), (a, -spread, b, ">")):
            if constant.constant and lift >= 0:
                reached = int(constant.text.strip("()")) << lift
                if abs(reached) > _fixed(other.format).largest_word:
                    return str(int((reached > 0) == (test == met)))
        left, right = f"(int64_t){a.text}", f"(int64_t){b.text}"
        if spread > 0:
            right += f" * {int64(1 << spread)}"
        elif spread < 0:
            left += f" * {int64(1 << -spread)}"
        return f"{left} {test} {right}"

    def _wrapped(self, angle: COperand, to: FixedPoint) -> str:
        fraction = _bits(angle)
        if fraction >= WIDTHS.stop - 2:  # below 2, whatever the word
            return self._word(angle, to)
        if not wraps_in_int64(angle.format.width_bits, fraction):
            raise CannotEmit("an angle to be wrapped has too few fraction bits for 64-bit integers")
        turn = pi_fixed(fraction + WRAP_GUARD_BITS + 1)
        number = f"{self._use('turns_off')}({angle.text}, {fraction}, {int64(turn)})"
        fraction += WRAP_GUARD_BITS
        if not _holds_pi(to):
            return self._rounded(number, fraction, to)
        right = max(-63, min(63, fraction - to.fraction_bits))
        most = int64(_largest_within(math.pi + to.ulp / 4, fraction))
        return f"{self._use('wrapped')}({number}, {right}, {to.width_bits}, {_pi_word(to)}, {most})"

    def unpack(self, term: COperand) -> str:
        """Return a valid word as an operand of a unit."""
        return f"{self._use('unpack_word', 'unpack')}({term.text}, {_bits(term)})"

    def pack(self, number: str, result: NumberFormat, *, angle: bool) -> str:
        """Return a unit's result as a word."""
        to = _fixed(result)
        shape = f"{number}, {to.fraction_bits}, {to.width_bits}"
        if not angle or not _holds_pi(to):
            return f"{self._use('pack_word', 'pack')}({shape})"
        most, bits = limit(math.pi + to.ulp / 4)
        return f"{self._use('pack_word_angle', 'pack_angle')}({shape}, {_pi_word(to)}, {int64(most)}, {bits})"

    def converted(self, term: COperand, result: NumberFormat) -> str:
        """Return a word, valid or not, in another format."""
        to = _fixed(result)
        if term.format == to:
            return term.text
        if term.constant:
            return self._word(term, to)
        return f"{self.is_valid(term)} ? {self._word(term, to)} : {self.invalid(to)}"

    def encode(self, number: str, result: NumberFormat) -> str:
        """Return the word of a double."""
        to = _fixed(result)
        return f"{self._use('encode_word', 'encode')}({number}, {to.fraction_bits}, {to.width_bits})"

    def decode(self, term: COperand) -> str:
        """Return the double that a word stands for."""
        unit = math.ldexp(1.0, -_bits(term)).hex()
        return f"{self.is_valid(term)} ? {term.text} * {unit} : NAN"

    def exponents(self, format_: NumberFormat) -> range:
        """Return the exponents of normalised operands that are not 0."""
        fraction, length = _fixed(format_).fraction_bits, format_.width_bits - 1
        least = -fraction - (self.system.operand_bits - 1)
        return range(least, least + length)

    def describe(self, format_: NumberFormat) -> str:
        """Return a few words on a format."""
        return f"{format_.width_bits} bits, {_fixed(format_).fraction_bits} of them after the point"

    def context(self) -> dict[str, Any]:
        """Return what the templates need to know."""
        return {
            "rounding": self.system.rounding,
            "wrap_guard": WRAP_GUARD_BITS,
            "inverse_turn": turn_fixed(0, _TURN_BITS),
            "inverse_turn_bits": _TURN_BITS,
        }

    def _use(self, section: str, name: str = "") -> str:
        self.needs[section] = None
        return name or section


def _fixed(format_: NumberFormat) -> FixedPoint:
    assert isinstance(format_, FixedPoint)
    return format_


def _bits(term: COperand) -> int:
    return _fixed(term.format).fraction_bits


def _holds_pi(format_: FixedPoint) -> bool:
    return format_.width_bits - format_.fraction_bits >= 3


def _pi_word(format_: FixedPoint) -> int:
    """Return the largest word that is at most pi."""
    return math.floor(math.ldexp(math.pi, format_.fraction_bits))


def _largest_within(number: float, fraction: int) -> int:
    """Return the largest integer that, as a double, is at most a number with so many fraction bits."""
    bound = math.ldexp(number, fraction)
    if bound >= 1 << SHIFT_LIMIT:
        return (1 << SHIFT_LIMIT) - 1
    first = math.floor(bound)
    return first + bisect_right(range(1, 1 << 12), bound, key=lambda step: float(first + step))
