"""The colours of every picture, and how each kind of unit looks, on paper, in grey and in the dark.

Pictures are drawn for paper, with presentation attributes only.  A page that shows them in the dark swaps
each colour for its counterpart by a style sheet, which has precedence over such attributes.
"""

from __future__ import annotations

from dataclasses import dataclass

INK = "#1b1f24"
MUTED = "#4a535c"
RULE = "#d8dee4"
PAPER = "#ffffff"
BAND = "#f4f6f8"
"""Every other row of a chart."""

WIRES = (INK, "#1f4e79", "#7a3b00", "#2d5a2d", "#6a2c70", "#5f6670")
SERIES = ("#1f5d96", "#9a4f00", "#2f7030", "#72418a", "#80660a", "#454c54")


@dataclass(frozen=True, slots=True)
class Look:
    """How a unit kind is drawn.  Lightness, border and corner differ, so that grey prints stay readable."""

    label: str
    fill: str
    stroke: str
    width: float = 1.2
    dash: str = ""
    radius: int = 2
    inner: bool = False


LOOKS: dict[str, Look] = {
    "standard": Look("standard CAU", "#a9cbed", "#1f5d96", 1.6),
    "implicit": Look("implicit CAU", "#fbdcb4", "#9a4f00", 1.6, inner=True),
    "mul": Look("multiplier", "#d3ecca", "#2f7030", 1.2),
    "cmul": Look("constant multiplier", "#f0f8ea", "#2f7030", 1.2, "4 2"),
    "add": Look("adder", "#fff6d0", "#80660a", 1.2, radius=10),
    "shift": Look("shift", PAPER, "#80660a", 1.2, "1.5 2", radius=10),
    "sign": Look("sign or check, no cycle", "#f1e4f6", "#72418a", 1.2, radius=12),
    "fifo": Look("FIFO, depth in words", PAPER, "#454c54", 1.0, radius=0),
    "input": Look("input", PAPER, INK, 1.2, radius=0),
    "output": Look("output", "#e6e8eb", INK, 1.6, radius=0),
    "link": Look("to or from another row", PAPER, "#5f6670", 1.0, "2 2", radius=0),
}
OTHER = Look("other unit", "#e6e8eb", "#454c54", 1.2, "6 2 1 2")

DARK = {
    INK: "#e6edf3", MUTED: "#b4bec9", RULE: "#3a424c", PAPER: "#14181d", BAND: "#1c2229",
    "#a9cbed": "#1d4d7c", "#fbdcb4": "#6b3d0c", "#d3ecca": "#214a25", "#f0f8ea": "#1a2f1c",
    "#fff6d0": "#453c12", "#f1e4f6": "#3a2545", "#e6e8eb": "#2b3238",
    "#1f5d96": "#6cb2f0", "#9a4f00": "#f0a858", "#2f7030": "#7cc47d", "#80660a": "#d9bd55",
    "#72418a": "#c79ade", "#454c54": "#a3adb8",
    "#1f4e79": "#7fb8ec", "#7a3b00": "#e0a068", "#2d5a2d": "#86c486", "#6a2c70": "#cf9ad6",
    "#5f6670": "#9aa4af",
}  # fmt: skip
"""The counterpart of each colour on a dark page."""


def look_of(kind: str) -> Look:
    """Return the look of a unit kind; kinds a target adds share one."""
    return LOOKS.get(kind, OTHER)


def dark_rules(scope: str) -> str:
    """Return style rules that swap the colours of the pictures in `scope` for those of a dark page."""
    return "\n".join(
        f'{scope} [{attribute}="{light}"] {{ {attribute}: {dark}; }}'
        for light, dark in DARK.items()
        for attribute in ("fill", "stroke")
    )
