"""What a rule of the search is, and what rules are given to work on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.exact.values import Store


class Need(Enum):
    """What a rule needs besides the values of the store."""

    GRAPHS = "the realisations of the passes, and the values that their nodes became"
    OUTPUTS = "the values of the outputs"
    LIFTING = "values may be scaled by common denominators"
    TOGETHER = "angles whose errors cancel are worth more products"


@dataclass(frozen=True, slots=True)
class Given:
    """What rules work on: a store, and the realisations that it was filled with.

    `moved` are the values that the nodes of each graph became; `lifting` allows to scale values by common
    denominators, but not for the cosine and sine of angles in which the roots of `apart` occur; `together`
    tells that what angles reach together counts, as checks say.
    """

    store: Store
    graphs: Sequence[Graph] = ()
    moved: Sequence[Sequence[tuple[Value, ...]]] = ()
    outputs: Mapping[str, Value] = field(default_factory=dict)
    lifting: bool = False
    apart: frozenset[Value] = frozenset()
    together: bool = False

    def has(self, need: Need) -> bool:
        """Tell whether a need is met."""
        match need:
            case Need.GRAPHS:
                return bool(self.graphs)
            case Need.OUTPUTS:
                return bool(self.outputs)
            case Need.LIFTING:
                return self.lifting
            case Need.TOGETHER:
                return self.together


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """Adds alternatives to a store, each equal to what is there, which the author of the rule proves.

    `Store.union` records the equality and believes it; `same_meaning` would only show a mistake on samples.
    Where the alternative has a value for fewer or more inputs, its conditions are compared: see `demands` of
    `rewrite.exact` and `Store.same_domain`.  New operations are those of `Store.make` after
    `store.begin(origin)`; the nodes grow meanwhile, so go over a copy.  A test asks for a problem in which
    each rule fires.

    Attributes:
        name: what it is called; occurs once.
        mathematics: the identity behind it, in one line.
        apply: adds what the rule finds.
        needs: what must be given, or the rule is passed over.
        words: the sentence that explains what it adds; formulas in it stand between backticks.  A plan
            tells it of CAUs, sums of angles and wraps.
        cases: other such sentences, by name, for what it adds besides.
        formulas: returns the sentences where they hold formulas of the problem, given the store and what the
            rule says they are about.
    """

    name: str
    mathematics: str
    apply: Callable[[Given], None]
    needs: frozenset[Need] = frozenset()
    words: str = ""
    cases: Mapping[str, str] = field(default_factory=dict)
    formulas: Callable[..., tuple[str, ...]] | None = None

    def run(self, given: Given) -> None:
        """Apply the rule if all that it needs is given; its words explain what it adds."""
        if all(given.has(need) for need in self.needs):
            self.tell(given.store)
            self.apply(given)

    def tell(self, store: Store, case: str = "") -> None:
        """Explain what is added from here on by the words of the rule, or by those of a case."""
        words = self.cases[case] if case else self.words
        store.reason = (words,) if words else ()

    def tell_of(self, store: Store, *about: object) -> None:
        """Explain what is added from here on by sentences with formulas."""
        assert self.formulas is not None
        store.reason = self.formulas(store, *about)
