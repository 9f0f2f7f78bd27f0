"""Names of a plan as identifiers of a generated language."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable


def unique_identifiers(names: Iterable[str], reserved: Callable[[str], object]) -> dict[str, str]:
    """Return an identifier for each name, all different: the name itself where the language allows it.

    Args:
        names: what is named, each once.
        reserved: tells whether the language has a use of its own for an identifier.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        made = re.sub(r"[^A-Za-z0-9_]", "_", name)
        if not re.match(r"[A-Za-z]", made):
            made = f"n{made}"
        if reserved(made):
            made += "_"
        while made in taken:
            made += "_"
        taken.add(made)
        found[name] = made
    return found
