"""Which cases of a test are quick, and which are exhaustive."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import pytest

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
