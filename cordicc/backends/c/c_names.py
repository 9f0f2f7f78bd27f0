"""Names and comments in generated C."""

from __future__ import annotations

import re
from collections.abc import Iterable

from cordicc.backends.identifiers import unique_identifiers

_RESERVED = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept const
    consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default delete do
    double dynamic_cast else enum errno explicit export extern false float for friend goto if inline int linux
    long main mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public
    register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast
    stderr stdin stdout struct switch template this thread_local throw true try typedef typeid typename typeof
    union unix unsigned using valid virtual void volatile wchar_t while xor xor_eq"""
_KEYWORDS = frozenset(_RESERVED.split())
_MACRO = re.compile(r"_.*|[A-Z][A-Z0-9_]{2,}")
"""What headers define: underscores in front, and capitals throughout."""


def identifiers(names: Iterable[str]) -> dict[str, str]:
    """Return a C identifier for each name, all different: the name itself where C allows it."""
    return unique_identifiers(names, lambda made: made in _KEYWORDS or _MACRO.fullmatch(made))


def comment(text: str) -> str:
    """Return text that can stand inside a C comment, on one line."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").replace("\\", "/")
