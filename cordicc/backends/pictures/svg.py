"""SVG text: a small writer and conservative text widths.

Presentation attributes only, no style sheets: a picture put inline into a page must not restyle the page.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cache
from html import escape
from typing import Any

from cordicc.backends.escaping import clean, quoted
from cordicc.backends.palette import INK, LOOKS, PAPER, Look, look_of

FONT = "Helvetica, Arial, 'DejaVu Sans', sans-serif"
_NARROW = frozenset("ijlI.,:;'|!()[]/ `")
_WIDE = frozenset("mwMW@%—…")


def number(value: float) -> str:
    """Write a coordinate with at most two decimals."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Estimate the width of `text` in pixels, on the wide side for any common sans-serif."""
    total = 0.0
    for char in text:
        total += _width(char)
    return total * size * (1.08 if bold else 1.0)


@cache
def _width(char: str) -> float:
    """Estimate the width of a character as a share of the size of the font."""
    if unicodedata.east_asian_width(char) in "WF" or ord(char) > 0xFFFF:
        return 1.1
    if char in _NARROW:
        return 0.37
    if char in _WIDE:
        return 1.0
    return 0.77 if char.isupper() or ord(char) > 0x17F else 0.63


def fitted(text: str, size: float, limit: float, *, bold: bool = False) -> str:
    """Shorten `text` with an ellipsis until it is at most `limit` pixels wide."""
    text = clean(text)
    if text_width(text, size, bold=bold) <= limit:
        return text
    while text and text_width(text + "…", size, bold=bold) > limit:
        text = text[:-1]
    return text.rstrip() + "…"


def wrapped(text: str, size: float, limit: float, lines: int) -> list[str]:
    """Break `text` at spaces into at most `lines` lines of `limit` pixels; the last one is shortened."""
    result: list[str] = []
    for word in clean(text).split():
        joined = f"{result[-1]} {word}" if result else word
        if not result or (text_width(joined, size) > limit and len(result) < lines):
            result.append(word)
        else:
            result[-1] = joined
    return [fitted(line, size, limit) for line in result]


@dataclass(slots=True)
class Svg:
    """An SVG document under construction; `prefix` keeps ids apart when several share a page."""

    prefix: str
    parts: list[str] = field(default_factory=list)

    def tag(self, name: str, content: str = "", **attributes: str | float) -> None:
        """Add an element; `content` is XML already, underscores in attribute names become hyphens."""
        body = f">{content}</{name}>" if content else "/>"
        self.parts.append(f"<{name}{_attributes(attributes)}{body}")

    def open(self, title: str = "", **attributes: str | float) -> None:
        """Start a group, with a tooltip if `title` is given."""
        self.parts.append(f"<g{_attributes(attributes)}>")
        if title:
            lines = "\n".join(quoted(line) for line in title.split("\n"))
            self.parts.append(f"<title>{lines}</title>")

    def close(self) -> None:
        """End the innermost group."""
        self.parts.append("</g>")

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float = 11,
        *,
        anchor: str = "start",
        bold: bool = False,
        fill: str = INK,
    ) -> None:
        """Write one line with its baseline at `y`."""
        weight: dict[str, Any] = {"font_weight": "bold"} if bold else {}
        self.tag("text", quoted(text), x=x, y=y, font_size=size, text_anchor=anchor, fill=fill, **weight)

    def box(self, x: float, y: float, width: float, height: float, look: Look) -> None:
        """Draw a box in the look of a unit kind."""
        style: dict[str, Any] = {"stroke": look.stroke, "stroke_width": look.width}
        if look.dash:
            style["stroke_dasharray"] = look.dash
        self.tag(
            "rect",
            x=x,
            y=y,
            width=width,
            height=height,
            rx=min(look.radius, width / 4),
            fill=look.fill,
            **style,
        )
        if look.inner:
            self.tag(
                "rect", x=x + 3, y=y + 3, width=width - 6, height=height - 6, fill="none",
                stroke=look.stroke, stroke_width=0.7,
            )  # fmt: skip

    def hatch(self, name: str, colour: str) -> str:
        """Define diagonal stripes and return the paint that refers to them."""
        ident = f"{self.prefix}-{name}"
        line = f'<path d="M0 6L6 0" stroke="{colour}" stroke-width="1"/>'
        pattern = (
            f'<pattern id="{ident}" width="6" height="6" patternUnits="userSpaceOnUse">'
            f'<rect width="6" height="6" fill="{PAPER}"/>{line}</pattern>'
        )
        self.tag("defs", pattern)
        return f"url(#{ident})"

    def stripes(self, x: float, y: float, width: float, height: float) -> None:
        """Draw a FIFO: a box with cells marked at both ends, its middle free for the depth."""
        look = LOOKS["fifo"]
        self.box(x, y, width, height, look)
        cells = [x + 4, x + 8, x + width - 8, x + width - 4]
        path = "".join(f"M{number(cell)} {number(y)}v{number(height)}" for cell in cells)
        self.tag("path", d=path, stroke=look.stroke, stroke_width=1)

    def legend(
        self, x: float, y: float, kinds: Iterable[str], limit: float, *, fifo_paint: str | None = None
    ) -> float:
        """Draw the legend in rows up to `limit` wide; return the y below it.

        `fifo_paint` is the fill of FIFOs where they are bars, not boxes with cells.
        """
        left = x
        for kind in kinds:
            look = look_of(kind)
            width = 34 + text_width(look.label, 10) + 16
            if left > x and left + width > x + limit:
                left, y = x, y + 20
            if kind == "fifo" and fifo_paint:
                self.box(left, y + 2, 26, 10, replace(look, fill=fifo_paint))
            elif kind == "fifo":
                self.stripes(left, y, 26, 13)
            else:
                self.box(left, y, 26, 13, look)
            self.text(left + 32, y + 10, look.label, 10)
            left += width
        return y + 20

    def document(self, width: float, height: float, label: str, *, inside: bool = False) -> str:
        """Return the finished document on white; `inside` a page its parts can be reached one by one."""
        role = "group" if inside else "img"
        size = f'width="{number(width)}" height="{number(height)}"'
        view = f'viewBox="0 0 {number(width)} {number(height)}"'
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} {view} role="{role}" '
            f'aria-label="{quoted(label)}" font-family="{escape(FONT, quote=False)}">'
        )
        ground = f'<rect {size} fill="{PAPER}"/>'
        return "\n".join([head, ground, *self.parts, "</svg>"]) + "\n"


def _attributes(attributes: dict[str, str | float]) -> str:
    return "".join(
        f' {name.replace("_", "-")}="{quoted(value) if isinstance(value, str) else number(value)}"'
        for name, value in attributes.items()
    )
