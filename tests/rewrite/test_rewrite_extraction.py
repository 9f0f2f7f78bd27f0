"""The cheapest choice among alternatives: against all choices there are, on small random ones."""

from __future__ import annotations

import random
from itertools import product

import pytest

from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.search.conditions import Requirement
from cordicc.rewrite.search.costs import Costs, ordered
from cordicc.rewrite.search.dominance import lean
from cordicc.rewrite.search.extraction import extract
from cordicc.rewrite.search.options import Alternatives, Option
from tests.support.selection import quick

COSTS = Costs(
    latency={"standard": 44, "implicit": 48, "mul": 4, "cmul": 4, "add": 2, "shift": 0, "sign": 0},
    area={"standard": 300, "implicit": 400, "mul": 90, "cmul": 60, "add": 10, "shift": 0, "sign": 1},
)


def option(op: str, operands: tuple[int, ...], *results: int) -> Option:
    """Return an option; a unit's parameter is its coordinate system."""
    params = (1,) if op in ("vector", "rotate") else ()
    return Option(op, params, operands, tuple((k,) for k in results), 0)


def alternatives(options: list[Option], **wanted: int) -> Alternatives:
    """Return alternatives in which nothing is left out."""
    classes = sorted({k for o in options for result in o.results for k in result})
    providers = {
        k: tuple(i for i, o in enumerate(options) if any(k in result for result in o.results))
        for k in classes
    }
    return Alternatives(tuple(options), wanted, providers, lambda value: value.node)


def units(choice: Alternatives) -> list[int]:
    return [COSTS.caus(o.op) for o in choice.options]


def figures(choice: Alternatives, provider: dict[int, int], goal: str) -> tuple[int, ...] | None:
    """Return what a choice costs, None if a class depends on itself."""
    finish: dict[int, int] = {}
    taken: set[int] = set()

    def time(k: int, above: tuple[int, ...]) -> bool:
        if k in above:
            return False
        if k not in finish:
            made = provider[k]
            taken.add(made)
            operands = choice.options[made].operands
            if not all(time(x, (*above, k)) for x in operands):
                return False
            # Of equal latencies that with fewer operations in a row is less.
            step = 64 * COSTS.cycles(choice.options[made].op, units(choice)[made]) + 1
            finish[k] = max((finish[x] + step for x in operands), default=0)
        return True

    if not all(time(k, ()) for k in choice.wanted.values()):
        return None
    ops = [choice.options[o].op for o in taken]
    sizes = sum(COSTS.size(op, COSTS.caus(op)) for op in ops)
    latency = max(finish[k] for k in choice.wanted.values())
    return ordered(goal, sum(COSTS.caus(op) for op in ops), ops.count("mul"), latency, sizes)


def random_alternatives(seed: int) -> Alternatives:
    """Return alternatives with few choices, in which classes may be made from one another."""
    draw = random.Random(seed)
    options = [option("input", (), 0), option("const", (), 1)]
    for k in range(2, 9):
        for _ in range(draw.choice((1, 1, 2, 3))):
            op = draw.choice(("add", "mul", "neg", "vector", "implicit"))
            width = {"neg": 1, "add": 2, "mul": 2, "vector": 3, "implicit": 3}[op]
            # Mostly earlier classes, so that some choice is free of circles.
            below = k if draw.random() < 0.7 else 9
            operands = tuple(draw.randrange(below) for _ in range(width))
            more = (draw.randrange(2, 9),) if op in ("vector", "implicit") and draw.random() < 0.5 else ()
            options.append(option(op, operands, k, *(x for x in more if x != k)))
        options.append(option("add", (k - 1, draw.randrange(k)), k))
    return alternatives(options, a=8, b=7)


@pytest.mark.parametrize("goal", ["processors", "latency", "area"])
@pytest.mark.parametrize("seed", quick(range(12), 0, 1, 2))
def test_no_choice_is_cheaper(seed: int, goal: str) -> None:
    choice = random_alternatives(seed)
    classes = list(choice.providers)
    every = (dict(zip(classes, made, strict=True)) for made in product(*choice.providers.values()))
    costs = [made for made in (figures(choice, provider, goal) for provider in every) if made is not None]
    found = extract(choice, [], frozenset(), COSTS, PassContext({}, goal))
    assert found is not None
    assert found.proven
    assert figures(choice, dict(found.provider), goal) == min(costs)


def test_beaten_options_are_left_out() -> None:
    options = [
        option("input", (), 0),
        option("const", (), 1),
        option("mul", (0, 0), 2),
        option("add", (2, 1), 3),  # 3 beats 4 and 5
        option("mul", (2, 1), 3),
        option("add", (2, 0), 3),
        option("vector", (2, 0, 1), 3, 4),  # yields more
        option("add", (3, 1), 3),  # of itself
    ]
    choice = alternatives(options, a=3, b=4)
    left = lean(choice, [], COSTS, units(choice))
    assert left.options == (0, 1, 2, 3, 6)
    assert left.providers[3] == (3, 6)
    met = Requirement(((3, 4),), None, "nonzero")
    assert 4 in lean(choice, [met], COSTS, units(choice)).options, "it meets a requirement"


def test_equal_options_leave_the_first() -> None:
    options = [option("input", (), 0), option("add", (0, 0), 1), option("sub", (0, 0), 1)]
    choice = alternatives(options, a=1)
    assert lean(choice, [], COSTS, units(choice)).options == (0, 1)


def test_a_requirement_keeps_its_unit() -> None:
    options = [
        option("input", (), 0),
        option("const", (), 1),
        option("neg", (0,), 2),
        option("vector", (0, 1, 1), 3, 4),
    ]
    choice = alternatives(options, a=2)
    needs = [Requirement(((3, 3),), None, "nonzero")]
    found = extract(choice, needs, frozenset(), COSTS, PassContext({}))
    assert found is not None
    assert found.provider[3] == 3
    assert extract(choice, [Requirement((), None, "any")], frozenset(), COSTS, PassContext({})) is None


def test_guards_count_as_area_only() -> None:
    options = [option("input", (), 0), option("neg", (0,), 1), option("vector", (0, 0, 0), 1, 2)]
    choice = alternatives(options, a=1)
    needs = [Requirement(((2, 2),), 0, "nonzero")]
    found = extract(choice, needs, frozenset(), COSTS, PassContext({}))
    assert found is not None
    assert found.guards == (0,)
    assert 2 not in found.provider
