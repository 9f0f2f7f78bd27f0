"""Text as XML and HTML can hold it."""

from __future__ import annotations

from html import escape

_ILLEGAL = dict.fromkeys((*range(0x20), 0x7F, 0xFFFE, 0xFFFF, *range(0xD800, 0xE000)), "\ufffd")
_ILLEGAL |= dict.fromkeys((0x09, 0x0A, 0x0D), " ")


def clean(text: str) -> str:
    """Replace what XML 1.0 cannot hold, and line breaks and tabs by spaces."""
    return text.translate(_ILLEGAL)


def quoted(text: str) -> str:
    """Escape for XML text and attributes."""
    return escape(clean(text), quote=True)
