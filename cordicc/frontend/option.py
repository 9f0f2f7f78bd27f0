"""Numbers given as options: the same constant expressions as in a problem file."""

from __future__ import annotations

from fractions import Fraction

from cordicc.base.diagnostics import InvalidInput, Report, Source, Span
from cordicc.frontend.document.yamltree import NodeKind, Places, YamlNode
from cordicc.frontend.reading import read_constant
from cordicc.frontend.scope import Scope
from cordicc.ir.graph import Builder


def option_number(text: str, option: str) -> Fraction:
    """Return the number of an option such as `0.5`, `2**-22` or `3*pi/4`.

    Raises:
        InvalidInput: the text is no constant expression.
    """
    source = Source(option, text)
    report = Report(source)
    node = YamlNode(NodeKind.SCALAR, Span(1, 1, len(text) + 1), 0, len(text), text)
    number = read_constant(node, option, Scope(Builder(), report), Places(source))
    report.raise_if_failed()
    if number is None:
        raise InvalidInput(report.ordered())
    return number
