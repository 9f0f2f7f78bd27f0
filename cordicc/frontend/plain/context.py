"""What the parsers of equations know: the constants, the vectors so far, the places in the file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from cordicc.base.diagnostics import Report, Span
from cordicc.frontend.document.yamltree import Places, YamlNode
from cordicc.frontend.plain.expansion import Expansion
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.scope import FileText, Scope

TARGET = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)\s*=(?!=)")
"""The name that the text of a malformed definition is about."""


@dataclass(slots=True)
class EquationContext:
    """What the equations of a file have in common.

    `scope` has the constants, for angles that are quarter turns; `vectors` the dimensions of vectors, 0
    for frames; `all_branches` asks for both branches of every solve that has one; `joints` counts those
    of all tables.
    """

    scope: Scope
    places: Places
    vectors: dict[str, int] = field(default_factory=dict)
    all_branches: bool = False
    joints: int = 0

    @property
    def report(self) -> Report:
        """Return the collector of diagnostics."""
        return self.scope.report

    def expansion(self, node: YamlNode, label: str, unknowns: frozenset[str] = frozenset()) -> Expansion:
        """Return a maker of the plain equations of an item."""
        return Expansion(self.scope, FileText(node, self.places), label, unknowns)


def one_line(node: YamlNode, places: Places, limit: int = 400) -> str:
    """Return the text of a node in one line, shortened if it is long."""
    text = " ".join(places.text[node.start : node.end].split())
    return text if len(text) <= limit else text[:limit] + " ..."


def failed(label: str, targets: Sequence[str], span: Span, written: str) -> list[ParsedEquation]:
    """Return names whose definition is malformed, so that their uses are not reported."""
    return [ParsedEquation(target, span, written, label=label) for target in targets]
