"""Which cases of a test are quick, and which are exhaustive; how many examples a property is tried on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import pytest
from hypothesis import settings

USUAL_EXAMPLES, QUICK_EXAMPLES = 100, 15
"""Examples on which a property is tried, in a run of everything and in the quick selection."""

settings.register_profile("everything", derandomize=True, deadline=None, max_examples=USUAL_EXAMPLES)
settings.register_profile("quick", derandomize=True, deadline=None, max_examples=QUICK_EXAMPLES)

WITHOUT_QUICK_CASE = pytest.StashKey[list[str]]()
"""In the configuration of pytest: the tests without one, of those that were collected."""


def without_quick_case(items: Sequence[pytest.Item]) -> list[str]:
    """Return the tests all of whose cases are exhaustive, but for those that say why."""
    quick: dict[str, bool] = {}
    for item in items:
        marks = list(item.iter_markers("exhaustive"))
        known = any(mark.kwargs.get("reason") for mark in marks)
        name = item.nodeid.partition("[")[0]
        quick[name] = quick.get(name, False) or known or not marks
    return [name for name, found in quick.items() if not found]


def examples(count: int) -> int:
    """Return how many of so many examples are tried in this run, in `settings` of a property."""
    return count * settings.default.max_examples // USUAL_EXAMPLES


def quick(cases: Iterable[Any], *chosen: Any) -> list[Any]:
    """Return cases for `parametrize`, of which the chosen ones are quick and all others exhaustive.

    Raises AssertionError if a chosen case is none of them.
    """
    every = list(cases)
    assert all(case in every for case in chosen), f"no such case: {set(chosen) - set(every)}"
    return [case if case in chosen else slow(case) for case in every]


def slow(case: Any) -> Any:
    """Return a case for `parametrize` that is exhaustive."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.exhaustive)
