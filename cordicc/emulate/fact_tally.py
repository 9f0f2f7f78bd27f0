"""What a problem assumes of its inputs, tested on the samples of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from cordicc.base.arrays import Bools, Samples
from cordicc.base.diagnostics import Diagnostic, Severity
from cordicc.emulate.ports import as_words
from cordicc.ir.facts import STRICT, Assumption, InputFacts
from cordicc.plan.model import Plan


@dataclass(frozen=True, slots=True)
class BrokenFact:
    """A fact that a sample breaks: the sample's number from 0, the fact, its sides there.

    `as_words`: the numbers given keep it, the words of the target that they become do not.
    """

    sample: int
    text: str
    left: float
    right: float
    as_words: bool


@dataclass(slots=True)
class FactTally:
    """Tells which samples keep the facts, counts those that do not, and remembers the first of them.

    The numbers given must keep every fact as `InputFacts.kept` says, and those that their words stand for the
    strict inequalities, which rounding may turn into equalities.  `rough` are those that keep an equation
    less exactly than double precision would: what rests on it is as far off, and no bound counts that.
    """

    facts: InputFacts
    words: Callable[[Samples], Samples]
    samples: int = 0
    broken: int = 0
    rough: int = 0
    first: BrokenFact | None = None

    @classmethod
    def of(cls, plan: Plan) -> FactTally | None:
        """Return the tally of a plan's facts, None if it assumes nothing."""
        facts = plan.problem.facts
        if not facts.items:
            return None
        return cls(facts, partial(as_words, plan))

    def kept(self, samples: Samples) -> Bools:
        """Return which samples keep every fact; `samples` are the next ones of the run, of shape (n,)."""
        count = len(next(iter(samples.values()), np.zeros(1)))
        kept = np.ones(count, dtype=bool)
        strict = any(fact.relation in STRICT for fact in self.facts.items)
        rounded = self.words(samples) if strict else samples
        for fact in self.facts.items:
            numbers = np.broadcast_to(self.facts.kept_one(fact, samples), kept.shape)
            words = numbers
            if fact.relation in STRICT:
                words = np.broadcast_to(self.facts.kept_one(fact, rounded), kept.shape)
            fresh = np.flatnonzero(~(numbers & words))
            if fresh.size and (self.first is None or self.samples + fresh[0] < self.first.sample):
                at = int(fresh[0])
                self.first = self._found(fact, rounded if numbers[at] else samples, at, bool(numbers[at]))
            kept &= numbers & words
        self.rough += int((kept & ~self.facts.exactly(samples)).sum())
        self.samples += count
        self.broken += count - int(kept.sum())
        return kept

    def _found(self, fact: Assumption, samples: Samples, at: int, as_words: bool) -> BrokenFact:
        sides = self.facts.sides(fact, {name: column[at : at + 1] for name, column in samples.items()})
        return BrokenFact(self.samples + at, fact.text, float(sides.left[0]), float(sides.right[0]), as_words)

    def told(self, noun: str) -> list[Diagnostic]:
        """Return a warning if any sample breaks a fact; `noun` is what the user calls a sample."""
        rough = []
        if self.rough:
            message = (
                f"{self.rough} of {self.samples} {noun}s keep what the problem assumes to 1e-6 alone, not to "
                "the rounding of double precision: no bound holds for them"
            )
            rough = [Diagnostic("W618", message, None, "give the inputs with more digits", Severity.WARNING)]
        if self.first is None:
            return rough
        verb = "breaks" if self.broken == 1 else "break"
        words = " as words of the target" if self.first.as_words else ""
        message = (
            f"{self.broken} of {self.samples} {noun}s {verb} what the problem assumes; the first is {noun} "
            f"{self.first.sample + 1}, where '{self.first.text}' has the sides {self.first.left!r} and "
            f"{self.first.right!r}{words}"
        )
        hint = (
            "no bound holds for them, errors are those of the others; correct these inputs, or the assumption"
        )
        return [Diagnostic("W617", message, None, hint, Severity.WARNING), *rough]
