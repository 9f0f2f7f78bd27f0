"""Exhaustive search over root-free circular shift sequences with a distributed scaling.

The candidates are those of Krieger and Hosticka 1996, section 3: a non-decreasing shift sequence S that
ends at a given shift, with a scaling digit eta in {-1, 0, 1} for each iteration.  Wanted are those with

1. convergence: each angle atan 2^-S is at most the sum of the later ones plus the last,
2. domain: 2 (sum of all angles + the last) is at least a given angle (root-free steps turn twice atan 2^-S),
3. scaling (their eq. 15): |prod(1 - eta 2^-2S) - prod 1/(1 + 2^-2S)| is at most a given error.

A shift may be left out or repeated as often as the length allows.  How the search is complete although it
visits few candidates, with g = prod(1 + 2^-2S):

- Shifts are chosen from the last downwards.  An angle is at most what lies behind it, so k more iterations
  at most double that sum k times, and add at most k times the largest angle: a lower bound of the length.
- The third condition says |P - 1| <= error * g for P = prod((1 + 2^-2S) (1 - eta 2^-2S)).  Each shift adds to
  log P a number between n log(1 - 2^-4S) and 2n log(1 + 2^-2S), so the later shifts reach at most an
  interval; a partial sum that misses the wanted interval by more is dropped.  Equal shifts count only by
  how many of their digits are 1, 0 and -1.

Sums are integers of `BITS` fraction bits, and every comparison is widened by more than their roundings, so
nothing is lost; the scaling error of what is found is verified in rational numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import cache
from math import comb
from typing import Any

from mpmath import MPContext

from cordicc.arith.kernels.shift_sequences import exact_angle, fixed

BITS = 140
"""Fraction bits of angles and logarithms."""

_MARGIN = 1 << 12
"""More than all roundings of a candidate together, in units of 2^-BITS."""

_TASK_ITERATIONS = 10
"""A task fixes the sequence from its end, up to so many iterations."""

_mp = MPContext()
_mp.prec = 200

Counts = tuple[int, ...]
"""How often each shift occurs, from the last shift downwards."""


class ZeroShift(StrEnum):
    """What S = 0, a turn by 90 degrees that stretches by exactly 2, may do.

    `NONE`: it does not occur.  `SCALED`: it is scaled by 1 - eta like any other (1 or 2; 0 destroys the
    vector).  `HALVED`: its factor 2 is dropped, which takes no adder: x and y are exchanged, one negated.
    """

    NONE = "none"
    SCALED = "scaled"
    HALVED = "halved"


@dataclass(frozen=True, slots=True)
class Conditions:
    """What is searched for: `domain_rad` is that of the whole rotation, `scaling_error` absolute."""

    final_shift: int
    domain_rad: Fraction
    scaling_error: Fraction
    max_iterations: int
    zero: ZeroShift = ZeroShift.NONE

    @property
    def first_shift(self) -> int:
        """The smallest shift that may occur."""
        return 1 if self.zero is ZeroShift.NONE else 0

    def candidates(self, length: int) -> int:
        """Return how many candidates of a length there are: shift sequences times 3^length digits.

        A halved S = 0 has no digit to choose: its sequences count with 3^(other iterations).
        """
        others = self.final_shift - 1  # shifts between S = 0 and the last
        if self.zero is ZeroShift.HALVED and self.final_shift > 0:
            counts: list[int] = [_multisets(others, n - 1) * 3**n for n in range(1, length + 1)]
            return sum(counts)
        digits: int = 3**length
        return self.shift_sequences(length) * digits

    def shift_sequences(self, length: int) -> int:
        """Return how many shift sequences of a length there are."""
        return _multisets(self.final_shift - self.first_shift, length - 1)


def _multisets(kinds: int, size: int) -> int:
    """Return the number of ways to choose `size` things of the last kind or `kinds` others."""
    return comb(kinds + size, size) if size >= 0 else 0


@dataclass(frozen=True, slots=True)
class ScaledSequence:
    """A candidate that meets all conditions; `error` is the exact, signed scaling error.

    The digit of a halved S = 0 is given as 0.
    """

    error: Fraction
    shifts: tuple[int, ...]
    eta: tuple[int, ...]

    @property
    def rank(self) -> tuple[Fraction, tuple[int, ...]]:
        """What candidates of one length are ordered by: the magnitude of the error, then the shifts."""
        return abs(self.error), self.shifts


@dataclass(frozen=True, slots=True)
class Length:
    """What there is of one length: sequences that meet conditions 1 and 2, those that meet all, the best."""

    converging: int = 0
    scalable: int = 0
    best: tuple[ScaledSequence, ...] = ()

    def joined(self, other: Length, limit: int) -> Length:
        """Return the sum of two parts, with the `limit` best of both."""
        best = tuple(sorted(self.best + other.best, key=lambda s: s.rank)[:limit])
        return Length(self.converging + other.converging, self.scalable + other.scalable, best)


Outcome = dict[int, Length]
"""What there is of each length; lengths without any converging sequence may be missing."""


@dataclass(frozen=True, slots=True)
class Prefix:
    """Counts of the last shifts, their total, and the sum of their angles plus the last."""

    counts: Counts
    total: int
    reach: int


@dataclass(frozen=True, slots=True)
class SearchTask:
    """The part of the search in which the counts of the last shifts are given."""

    conditions: Conditions
    prefix: Prefix
    limit: int


def tasks(conditions: Conditions, limit: int) -> list[SearchTask]:
    """Split the search into parts, in a fixed order, of which each keeps the `limit` best of each length.

    Together they cover every candidate; where S = 0 is allowed, every one in which it occurs, since the
    others are those of `ZeroShift.NONE`.
    """
    found = []
    last = _angle(conditions.final_shift)
    domain = _domain_units(conditions.domain_rad)
    front = [Prefix((n,), n, (n + 1) * last) for n in range(1, conditions.max_iterations + 1)]
    while front:
        prefix = front.pop()
        if _complete(conditions, prefix) or prefix.total >= _TASK_ITERATIONS:
            found.append(SearchTask(conditions, prefix, limit))
        else:
            front += _extended(conditions, prefix, domain)
    return found


def run(task: SearchTask) -> Outcome:
    """Search one part."""
    outcome: Outcome = {}
    conditions = task.conditions
    domain = _domain_units(conditions.domain_rad)
    front = [task.prefix]
    while front:
        prefix = front.pop()
        if not _complete(conditions, prefix):
            front += _extended(conditions, prefix, domain)
        elif 2 * prefix.reach >= domain:
            best = _best_scaling(conditions, prefix.counts)
            part = Length(1, int(best is not None), () if best is None else (best,))
            outcome[prefix.total] = outcome.get(prefix.total, Length()).joined(part, task.limit)
    return outcome


def merge(outcomes: Iterable[Outcome], limit: int) -> Outcome:
    """Return the whole of parts, in whatever order they come."""
    whole: Outcome = {}
    for outcome in outcomes:
        for length, part in outcome.items():
            whole[length] = whole.get(length, Length()).joined(part, limit)
    return dict(sorted(whole.items()))


def outcomes(parts: Sequence[SearchTask], jobs: int) -> Iterator[Outcome]:
    """Run the parts in so many processes and yield what they find, in the order of the parts."""
    if jobs == 1 or len(parts) < 2:
        yield from map(run, parts)
        return
    from cordicc.studies.processes import process_pool

    with process_pool(min(jobs, len(parts))) as pool:
        yield from pool.map(run, parts, chunksize=max(1, min(16, len(parts) // (4 * jobs))))


@cache
def _angle(shift: int) -> int:
    angle: int = fixed(exact_angle(1, shift, double=False), BITS)
    return angle


def _domain_units(domain: Fraction) -> int:
    """Return the wanted domain, less the roundings, its own (of pi, say) among them."""
    return int(domain * (1 << BITS)) - _MARGIN


def _complete(conditions: Conditions, prefix: Prefix) -> bool:
    return len(prefix.counts) > conditions.final_shift - conditions.first_shift


def _extended(conditions: Conditions, prefix: Prefix, domain: int) -> list[Prefix]:
    """Return what the next smaller shift can make of a prefix, less what cannot meet conditions 1 and 2."""
    left = conditions.max_iterations - prefix.total
    highest = min(prefix.reach << left, prefix.reach + left * _angle(conditions.first_shift))
    if 2 * highest < domain:
        return []
    shift = conditions.final_shift - len(prefix.counts)
    angle = _angle(shift)
    most = left if angle <= prefix.reach + _MARGIN else 0
    least = 1 if shift == 0 else 0
    return [
        Prefix((*prefix.counts, n), prefix.total + n, prefix.reach + n * angle)
        for n in range(least, most + 1)
    ]


@dataclass(frozen=True, slots=True)
class _Digits:
    """Digits of equal shifts: how many are 1 and -1, and what they add to log P."""

    log: int
    plus: int
    minus: int


@cache
def _choices(shift: int, count: int, zero: ZeroShift) -> tuple[_Digits, ...]:
    """Return every choice of digits for `count` iterations with one shift."""
    if shift == 0:
        log2 = fixed(+_mp.ln2, BITS)
        if zero is ZeroShift.HALVED:
            return (_Digits(0, 0, 0),)
        return tuple(_Digits((count + minus) * log2, 0, minus) for minus in range(count + 1))
    square = _mp.ldexp(_mp.mpf(1), -2 * shift)
    more, less = fixed(_mp.log1p(square), BITS), fixed(_mp.log1p(-square), BITS)
    return tuple(
        _Digits((count + minus) * more + plus * less, plus, minus)
        for plus in range(count + 1)
        for minus in range(count + 1 - plus)
    )


def _window(bound: Any) -> tuple[int, int]:
    """Return where log P must lie for |P - 1| <= bound, widened by the roundings."""
    lowest = fixed(_mp.log1p(-bound), BITS) if bound < 1 else -(1 << (BITS + 20))
    return lowest - _MARGIN, fixed(_mp.log1p(bound), BITS) + _MARGIN


def _best_scaling(conditions: Conditions, counts: Counts) -> ScaledSequence | None:
    """Return the shifts of `counts` with the digits whose |log P| is least, None if none will do.

    Branch and bound: a partial sum is dropped if the later shifts cannot bring it into the window, or
    not nearer to 0 than the best so far; the choice that can end nearest to the middle is tried first.
    """
    final, zero, wanted = conditions.final_shift, conditions.zero, conditions.scaling_error
    used = [(final - i, n) for i, n in reversed(list(enumerate(counts))) if n]
    levels = [_choices(shift, n, zero) for shift, n in used]
    low, high = (sum(edge) for edge in zip(*(_range(*item, zero) for item in used), strict=True))
    numerator, exponent = _gain(used, zero)
    bound = _mp.ldexp(_mp.mpf(wanted.numerator * numerator) / wanted.denominator, -exponent)
    whole = _window(bound)
    if high < whole[0] or low > whole[1]:
        return None
    rests = _rests([_range(*item, zero) for item in used])
    nearest: ScaledSequence | None = None
    least = max(-whole[0], whole[1]) + 1
    front: list[tuple[int, tuple[_Digits, ...]]] = [(0, ())]
    while front:
        total, chosen = front.pop()
        level = len(chosen)
        low, high = (total + edge for edge in rests[level])
        if high < whole[0] or low > whole[1] or max(low, -high) >= least:
            continue
        if level < len(levels):
            middle = -sum(rests[level + 1]) // 2
            children = [(total + digits.log, (*chosen, digits)) for digits in levels[level]]
            front += sorted(children, key=lambda child: -abs(child[0] - middle))
        else:
            found = _sequence(used, chosen, zero)
            if abs(found.error) <= wanted:
                nearest, least = found, abs(total)
    return nearest


@cache
def _range(shift: int, count: int, zero: ZeroShift) -> tuple[int, int]:
    """Return the least and the greatest sum of the digits of equal shifts."""
    logs = [digits.log for digits in _choices(shift, count, zero)]
    return min(logs), max(logs)


def _rests(ranges: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the least and the greatest sum of all levels, of all but the first, and so on to none."""
    rests = [(0, 0)]
    for low, high in reversed(ranges):
        rests.append((rests[-1][0] + low, rests[-1][1] + high))
    return rests[::-1]


def _gain(used: Sequence[tuple[int, int]], zero: ZeroShift) -> tuple[int, int]:
    """Return the product of 1 + 2^-2S, without that of a halved S = 0, as n and e of n 2^-e."""
    numerator, exponent = 1, 0
    for shift, count in used:
        if shift or zero is not ZeroShift.HALVED:
            numerator *= (4**shift + 1) ** count
            exponent += 2 * shift * count
    return numerator, exponent


def _sequence(used: Sequence[tuple[int, int]], choice: Sequence[_Digits], zero: ZeroShift) -> ScaledSequence:
    """Return the candidate with its exact error; equal shifts have their digits in falling order."""
    scaling, exponent = 1, 0  # scaling 2^-exponent
    shifts: list[int] = []
    eta: list[int] = []
    for (shift, count), digits in zip(used, choice, strict=True):
        scaling *= (4**shift - 1) ** digits.plus * (4**shift + 1) ** digits.minus
        exponent += 2 * shift * (digits.plus + digits.minus)
        shifts += [shift] * count
        eta += [1] * digits.plus + [0] * (count - digits.plus - digits.minus) + [-1] * digits.minus
    gain, gain_exponent = _gain(used, zero)
    difference = scaling * gain - (1 << (exponent + gain_exponent))
    return ScaledSequence(Fraction(difference, gain << exponent), tuple(shifts), tuple(eta))
