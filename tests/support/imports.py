"""The statements of a module, and with them its imports."""

from __future__ import annotations

import ast
from collections.abc import Iterator

HOLDERS = (ast.stmt, ast.excepthandler, ast.match_case)
"""What has statements in it; expressions, most of a tree, have none."""


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements below a node, and what else holds statements."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, HOLDERS):
            yield node
            yield from statements(node)
