"""Equations of a file before their names are looked up."""

from __future__ import annotations

from dataclasses import dataclass

from cordicc.base.diagnostics import Span
from cordicc.expressions.syntax import Expr, names
from cordicc.frontend.scope import Text
from cordicc.frontend.solving.solve import SolveRequest

CHECK = "check."
"""Before the name of a check where it is an equation: names that users write have no dot."""


@dataclass(frozen=True, slots=True)
class ParsedEquation:
    """An equation or solve; `target` alone is set if it is malformed.

    `label` names the item of the file of which this is a part, a vector or a frame; `hidden` parts
    have names that no user can write.  `depends` are the names of the file that the definition rests
    on, where that is more than the names in it.
    """

    target: str
    span: Span
    written: str
    definition: tuple[Expr, Text] | None = None
    request: SolveRequest | None = None
    label: str = ""
    hidden: bool = False
    depends: frozenset[str] | None = None

    @property
    def of_check(self) -> bool:
        """Tell whether this is a check or a part of one."""
        return self.target.startswith(CHECK)

    @property
    def names(self) -> frozenset[str]:
        """Return the names in the definition, hidden ones among them, without the unknowns."""
        if self.definition is not None:
            return frozenset(n.name for n in names(self.definition[0]))
        if self.request is not None:
            sides = [side for r, _ in self.request.all_relations for side in (r.left, r.right)]
            return frozenset(n.name for side in sides for n in names(side)) - set(self.request.unknowns)
        return frozenset()

    @property
    def uses(self) -> frozenset[str]:
        """Return the names of the file on which the definition depends."""
        return self.names if self.depends is None else self.depends
