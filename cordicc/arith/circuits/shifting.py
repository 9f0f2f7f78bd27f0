"""Blocks of circuits: lengths of numbers, shifts by them, products with constants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal, Operand
from cordicc.arith.circuits.limits import limited


def length_of(b: CircuitBuilder, size: CircuitSignal) -> CircuitSignal:
    """Return the bits of a number that is not negative, 0 of 0."""
    assert size.lo >= 0
    bits = size.hi.bit_length()
    # Zeros in front of a number of 2^k bits, half by half; the ones behind it end them.
    places = 1 << max(0, (bits - 1).bit_length())
    behind = places - bits
    rest = (size << behind) + ((1 << behind) - 1)
    zeros: CircuitSignal = b.of(0)
    half = places // 2
    while half:
        top = rest >> half
        none = top.equals(0)
        zeros = zeros + (none << (half.bit_length() - 1))
        rest = b.mux(none, top, b.low(rest, half))
        half //= 2
    if not behind:
        zeros = zeros + ~rest
    return b.narrowed(bits - zeros, 0, bits)


def shlv(
    b: CircuitBuilder, a: Operand, count: CircuitSignal, within: tuple[int, int] | None = None
) -> CircuitSignal:
    """Return a 2^count, a multiplexer a bit of the count; it is known to lie within a range perhaps."""
    found = b.of(a)
    if within is not None and count.lo > 0:
        # The part of every count is no multiplexer's, and what the others move has fewer bits.
        least = count.lo
        return shlv(b, a, count - least, (within[0] >> least, -(-within[1] >> least))) << least
    for place in reversed(range(count.hi.bit_length())):
        found = b.mux(b.bit(count, place), found, found << (1 << place))
        if within is not None:
            found = b.narrowed(found, *within)
    return found if within is not None else _between(b, found, b.of(a), count, b.shl)


def shrv(b: CircuitBuilder, a: Operand, count: CircuitSignal) -> CircuitSignal:
    """Return a / 2^count rounded down, a multiplexer a bit of the count."""
    found = b.of(a)
    for place in reversed(range(count.hi.bit_length())):
        found = b.mux(b.bit(count, place), found, found >> (1 << place))
    return _between(b, found, b.of(a), count, b.shr)


def _between(
    b: CircuitBuilder,
    found: CircuitSignal,
    a: CircuitSignal,
    count: CircuitSignal,
    shift: Callable[[int, int], CircuitSignal],
) -> CircuitSignal:
    """Return a shifted number with the range that the ends of the count leave."""
    ends = [(shift(a.lo, n).lo, shift(a.hi, n).hi) for n in (count.lo, count.hi)]
    return b.narrowed(found, min(low for low, _ in ends), max(high for _, high in ends))


def shifted(
    b: CircuitBuilder,
    number: CircuitSignal,
    right: CircuitSignal,
    most: int,
    within: tuple[int, int] | None = None,
) -> CircuitSignal:
    """Return number / 2^right rounded half up; `right` may be negative.

    Args:
        b: the builder.
        number: an integer.
        right: how far it is shifted.
        most: a count from which on the result is 0 in any case.
        within: a range that the result is known to lie in, None of none but what follows.
    """
    right = limited(b, right, most)
    if right.lo == right.hi:
        found = b.rounded(number, right.lo)
    elif right.hi <= 0:
        return shlv(b, number, -right, within)
    else:
        lift = max(0, -right.lo)
        found = b.rounded(shrv(b, number << (lift + 1), right + lift), 1)
    return found if within is None else b.narrowed(found, *within)


def digits_of(constant: int) -> list[tuple[int, int]]:
    """Return the canonical signed digits of a positive integer: places and signs, the highest first."""
    found, place = [], 0
    while constant:
        if constant & 1:
            sign = 2 - (constant & 3)
            found.append((place, sign))
            constant -= sign
        constant >>= 1
        place += 1
    return found[::-1]


def times(b: CircuitBuilder, number: CircuitSignal, constant: int) -> CircuitSignal:
    """Return a product with a positive constant: a tree of adders over its signed digits.

    Two digits that stand apart as others do are added once, as long as there are such: Hartley,
    "Subexpression sharing in filters using canonic signed digit multipliers", IEEE Trans. CAS II, 1996.
    """
    terms = [Term(number, place, sign) for place, sign in digits_of(constant)]
    while (found := _most_frequent(terms)) is not None:
        pair, places = found
        shared = _pair(b, [pair[0], pair[1]])
        for high, low in places:
            sign = high.sign * pair[0].sign * shared.sign
            terms.remove(high)
            terms.remove(low)
            terms.append(Term(shared.number, low.place - pair[1].place + shared.place, sign))
        terms.sort(key=lambda term: -term.place)
    while len(terms) > 1:
        terms = [_pair(b, terms[at : at + 2]) for at in range(0, len(terms), 2)]
    ((result, place, sign),) = terms
    assert sign > 0
    exact = result << place
    ends = (number.lo * constant, number.hi * constant)
    return b.narrowed(exact, min(ends), max(ends))


class Term(NamedTuple):
    """A summand of a product: a number times 2^place, or less that."""

    number: CircuitSignal
    place: int
    sign: int


_Pairs = tuple[tuple[Term, Term], list[tuple[Term, Term]]]


def _most_frequent(terms: Sequence[Term]) -> _Pairs | None:
    """Return the pair of terms that occurs most often, shifted or negated, and where; None of no two."""
    groups: dict[tuple[int, int, int, int], list[tuple[Term, Term]]] = {}
    for at, high in enumerate(terms):
        for low in terms[at + 1 :]:
            key = (high.number.number, low.number.number, high.place - low.place, high.sign * low.sign)
            groups.setdefault(key, []).append((high, low))
    best: list[tuple[Term, Term]] = []
    for pairs in groups.values():
        taken: set[Term] = set()
        chosen = []
        for high, low in pairs:
            if high not in taken and low not in taken:
                chosen.append((high, low))
                taken |= {high, low}
        if len(chosen) > max(len(best), 1):
            best = chosen
    return (best[-1], best) if best else None


def _pair(b: CircuitBuilder, terms: Sequence[Term]) -> Term:
    if len(terms) == 1:
        return terms[0]
    high, low = terms
    raised = high.number << (high.place - low.place)
    if high.sign == low.sign:
        return Term(raised + low.number, low.place, high.sign)
    # A difference that is added.
    return Term(raised - low.number if high.sign > 0 else low.number - raised, low.place, 1)
