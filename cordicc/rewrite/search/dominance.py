"""Fewer alternatives with the same cheapest choice: an option that another one beats is left out.

One option beats another if it yields all that the other one yields from no more operands, and costs no more
by any goal.  Inputs and constants do not count among the operands.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from cordicc.rewrite.search.conditions import Requirement
from cordicc.rewrite.search.costs import Costs
from cordicc.rewrite.search.options import Alternatives, Option


@dataclass(frozen=True, slots=True)
class Lean:
    """What is left: options by their numbers, in order, and the options that yield each class."""

    options: tuple[int, ...]
    providers: Mapping[int, tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class _Offer:
    """Classes that an option yields, those it takes, what it costs by each goal."""

    yields: frozenset[int]
    takes: frozenset[int]
    costs: tuple[int, ...]

    def beats(self, other: _Offer) -> bool:
        """Tell whether nothing is lost by taking this offer for another one."""
        return (
            other.yields <= self.yields
            and self.takes <= other.takes
            and all(own <= its for own, its in zip(self.costs, other.costs, strict=True))
        )


def lean(
    choice: Alternatives, requirements: Sequence[Requirement], costs: Costs, units: Sequence[int]
) -> Lean:
    """Return the options that no other one beats; those that meet a requirement are kept.

    Args:
        choice: the alternatives.
        requirements: the conditions.
        costs: what operations cost.
        units: CAUs of each option.
    """
    meeting = {pair for requirement in requirements for pair in requirement.met_by}
    roots = [*choice.wanted.values(), *(k for k, _ in meeting if k in choice.providers)]
    roots += [r.subject for r in requirements if r.subject is not None]
    found = Lean(tuple(range(len(choice.options))), choice.providers)
    while True:
        less = _live(choice, _unbeaten(choice, found, {o for _, o in meeting}, costs, units), roots)
        if less == found:
            return found
        found = less


def _unbeaten(
    choice: Alternatives, found: Lean, kept: Collection[int], costs: Costs, units: Sequence[int]
) -> dict[int, tuple[int, ...]]:
    """Return by class the options that are not beaten, none that takes what it yields."""
    given = {k for k, makers in found.providers.items() if any(_is_given(choice.options[o]) for o in makers)}
    offers = {o: _offer(choice.options[o], found, given, costs, units[o]) for o in found.options}
    beaten: set[int] = set()
    for number, offer in offers.items():
        rivals = found.providers[min(offer.yields)] if offer.yields else ()
        if number not in kept and any(
            rival != number
            and rival not in beaten
            and offers[rival].beats(offer)
            and (rival < number or not offer.beats(offers[rival]))
            for rival in rivals
        ):
            beaten.add(number)
    return {
        k: tuple(o for o in makers if o not in beaten and k not in choice.options[o].operands)
        for k, makers in found.providers.items()
    }


def _is_given(option: Option) -> bool:
    return option.op in ("input", "const")


def _offer(option: Option, found: Lean, given: Collection[int], costs: Costs, units: int) -> _Offer:
    yields = frozenset(k for result in option.results for k in result if k in found.providers)
    standard = units if costs.preferred and option.op != "implicit" else 0
    cycles, size = costs.cycles(option.op, units), costs.size(option.op, units)
    takes = frozenset(k for k in option.operands if k not in given)
    return _Offer(yields, takes, (units, standard, int(option.op == "mul"), cycles, size))


def _live(choice: Alternatives, providers: Mapping[int, tuple[int, ...]], roots: Iterable[int]) -> Lean:
    """Return what is on the way to some classes."""
    seen, live = set(roots), set()
    todo = list(seen)
    while todo:
        for number in providers[todo.pop()]:
            if number not in live:
                live.add(number)
                new = set(choice.options[number].operands) - seen
                seen |= new
                todo += new
    return Lean(tuple(sorted(live)), {k: makers for k, makers in providers.items() if k in seen})
