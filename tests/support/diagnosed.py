"""Problem files of any text: they load, or what is wrong with them is a diagnostic."""

from cordicc.base.codes import CODES
from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.frontend.load import parse_problem
from cordicc.ir.graph import Graph
from cordicc.ir.text import parse_graph, print_graph
from cordicc.ir.well_formed import verify


def check_text(text: str) -> None:
    """Load a text; whatever is wrong with it must be a diagnostic with a known code."""
    try:
        loaded = parse_problem(Source("p.yaml", text))
    except InvalidInput as error:
        found = error.diagnostics
    else:
        check_graph(loaded.problem.graph)
        return
    assert found
    for diagnostic in found:
        assert diagnostic.code in CODES
        assert diagnostic.render()


def check_graph(graph: Graph) -> None:
    """Fail unless a graph is well-formed and reads back as printed."""
    verify(graph)
    assert parse_graph(print_graph(graph)) == graph
