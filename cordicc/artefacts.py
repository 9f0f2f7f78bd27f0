"""The table of what can be written for a plan, and the writing of it.

A new artefact is a file with its emitter, and a line here: `cordicc compile --emit`, `cordicc draw` and the
Python interface take their choices from the table.  An emitter is imported when it is used.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cordicc.backends.report.page import Explored
    from cordicc.backends.rtl.reset_style import ResetStyle
    from cordicc.plan.model import Plan


class Written(Enum):
    """When an artefact is written: into every folder of results, if it is asked for, or only if drawn."""

    ALWAYS = "always"
    IF_ASKED = "if asked for"
    IF_DRAWN = "if drawn"


@dataclass(frozen=True, slots=True)
class Artefact:
    """What can be written for a plan: a file, or files that belong together.

    `file` is the name of the file; None: the names follow from the plan's.  `emitter` says where the function
    is that writes it, as "module:function" below `cordicc`.  It takes the plan and returns the text of the
    file, or where `file` is None the texts by name; `cordicc.base.seals` knows how each is marked.  That of a
    picture also takes the width in pixels of the rows into which it may fold what it shows; None: a single
    row.  If the artefact has `samples` the emitter also takes what runs the plan, and may be told of how many
    samples drawn at random it does.  If it has a `reset` it may be told of which style that is.
    """

    name: str
    file: str | None
    about: str
    written: Written
    emitter: str
    samples: bool = False
    reset: bool = False

    @property
    def is_picture(self) -> bool:
        """Whether it is a view of the plan, to be drawn by itself."""
        return self.file is not None and self.file.endswith(".svg")

    def emit(self, plan: Plan, *options: Any, reset: ResetStyle | None = None) -> Mapping[str, str]:
        """Return its texts by the names of the files.

        Args:
            plan: what is written.
            options: of its emitter.
            reset: the style of its reset if it has one; None: the usual one.

        Raises:
            Unattainable: it has no form for the plan.
        """
        from cordicc.base.seals import sealed

        module, _, function = self.emitter.partition(":")
        named = {"reset": reset} if self.reset and reset is not None else {}
        if self.samples:
            from cordicc.emulate import functional

            options = (partial(functional.run, plan, plan.arithmetic), *options)
        made = getattr(import_module(f"cordicc.{module}"), function)(plan, *options, **named)
        texts = made if self.file is None else {self.file: made}
        return {name: sealed(name, text) for name, text in texts.items()}


_ALWAYS, _IF_ASKED, _IF_DRAWN = Written
_PICTURES = "backends.pictures"

# fmt: off
ARTEFACTS = {each.name: each for each in (
    Artefact("plan", "plan.json", "the plan", _ALWAYS, "plan.file:dump"),
    Artefact("report", "report.html", "a page that explains it", _ALWAYS, "backends.report.page:render"),
    Artefact("datapath", "datapath.svg", "units and wires", _ALWAYS, f"{_PICTURES}.datapath:render"),
    Artefact("schedule", "schedule.svg", "units over time", _ALWAYS, f"{_PICTURES}.schedule_chart:render"),
    Artefact("graph", "graph.svg", "operations by dependence", _IF_DRAWN, f"{_PICTURES}.graph_view:render"),
    Artefact("script", "simulate.py", "a script that runs it", _ALWAYS, "backends.script:render"),
    Artefact("c", None, "a bit-accurate C99 model with its header", _IF_ASKED, "backends.c.c_model:files"),
    Artefact(
        "verilog", None, "Verilog with a bench, in rtl/", _IF_ASKED, "backends.rtl.package:files", True, True,
    ),
    Artefact(
        "verilog-vectors", None, "samples as integers, for a bench of yours", _IF_ASKED,
        "backends.rtl.sample_vectors:files", True,
    ),
)}
# fmt: on
"""By name, in the order in which they are written."""

ON_REQUEST = {name: each for name, each in ARTEFACTS.items() if each.written is Written.IF_ASKED}
"""What is only written if asked for: the choices of `--emit`."""

ALWAYS_WRITTEN = tuple(
    each.file for each in ARTEFACTS.values() if each.written is Written.ALWAYS and each.file
)
"""The files of every folder of results."""

VIEWS = tuple(name for name, each in ARTEFACTS.items() if each.is_picture)
"""What can be drawn of a plan."""


def artefacts(
    plan: Plan,
    more: Iterable[str] = (),
    samples: Mapping[str, int] | None = None,
    reset: ResetStyle | None = None,
) -> dict[str, str]:
    """Return the files of an output folder by name: what is always written, and `more` of `ARTEFACTS`.

    `samples` tells of those which have samples how many are drawn, by name, if not as many as usual, and
    `reset` those which have one how they are reset.

    Raises:
        Unattainable: one of them has no form for the plan.
    """
    asked = frozenset(more)
    files: dict[str, str] = {}
    for name, each in ARTEFACTS.items():
        if each.written is Written.ALWAYS or name in asked:
            counts = [samples[name]] if samples and name in samples else []
            files |= each.emit(plan, *counts, reset=reset)
    return files


def report_page(plan: Plan, explored: Explored | None = None) -> str:
    """Return the report of a plan as HTML, with the trade-off of its problem if that is known."""
    (text,) = ARTEFACTS["report"].emit(plan, explored).values()
    return text


def picture(plan: Plan, view: str, width: float | None = None) -> str:
    """Return the SVG of one of `VIEWS`, folded into rows of `width` pixels if it can be; None: in one row."""
    (text,) = ARTEFACTS[view].emit(plan, width).values()
    return text
