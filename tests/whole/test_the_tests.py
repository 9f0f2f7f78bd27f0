"""What holds for every test: helpers of `tests.support`, no private names, an assertion, a quick case."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache

import pytest

from tests.support.imports import statements
from tests.support.paths import ROOT
from tests.support.selection import WITHOUT_QUICK_CASE

FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts): path
    for path in sorted((ROOT / "tests").rglob("*.py"))
}
PRIVATE = re.compile(r"(^|\.)_[a-zA-Z]\w*(?<!_)$")
"""A name or dotted name that ends privately; `_repr_svg_` and its like are for notebooks to call."""

NAMED_TUPLES = {"_asdict", "_fields", "_replace"}
ASSERTING = {"raises", "warns", "fail", "golden", "verify", "verify_bare"}
"""Calls that fail a test, the verifiers of the package among them.

So do those of `numpy.testing`, and of functions with an `assert` in them.
"""


@cache
def parsed(module: str) -> ast.Module:
    return ast.parse(FILES[module].read_bytes())


@cache
def imported(module: str) -> dict[str, str]:
    """Return the dotted name that each imported name of a module stands for."""
    found = {}
    for node in statements(parsed(module)):
        if isinstance(node, ast.ImportFrom):
            found |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            whole = {alias.asname: alias.name for alias in node.names if alias.asname}
            found |= whole | {
                alias.name.partition(".")[0]: alias.name.partition(".")[0] for alias in node.names
            }
    return found


def dotted(node: ast.expr) -> str:
    """Return `a.b.c` for names and attributes, the empty text for all else."""
    if isinstance(node, ast.Name):
        return node.id
    before = dotted(node.value) if isinstance(node, ast.Attribute) else ""
    return f"{before}.{node.attr}" if before and isinstance(node, ast.Attribute) else ""


def private(name: str) -> bool:
    return PRIVATE.search(name) is not None and name.rpartition(".")[2] not in NAMED_TUPLES


def test_no_helper_comes_from_another_test_module() -> None:
    wrong = [
        f"{module}: {name}"
        for module in FILES
        for name in imported(module).values()
        if re.search(r"^tests\..*\btest_", name)
    ]
    assert not wrong, "\n".join(wrong)


def private_names(module: str) -> Iterator[str]:
    """Yield the private names of the package that a module imports, reads or patches."""
    names = imported(module)
    of_package = {name for name, full in names.items() if full.partition(".")[0] == "cordicc"}
    yield from (full for full in names.values() if full.startswith("cordicc") and private(full))
    for node in ast.walk(parsed(module)):
        if isinstance(node, ast.Attribute) and private(node.attr):
            name = dotted(node)
            if name.partition(".")[0] in of_package:
                yield name
        if isinstance(node, ast.Call) and dotted(node.func).rpartition(".")[2] in (
            "setattr",
            "delattr",
            "getattr",
        ):
            texts = (a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str))
            yield from filter(private, texts)


def test_no_private_name_is_pinned() -> None:
    wrong = [f"{module}: {name}" for module in FILES for name in private_names(module)]
    assert not wrong, "\n".join(wrong)


Function = ast.FunctionDef | ast.AsyncFunctionDef


@cache
def functions(module: str) -> dict[str, list[Function]]:
    """Return the functions and methods of a module by name."""
    found: dict[str, list[Function]] = {}
    for node in statements(parsed(module)):
        if isinstance(node, Function):
            found.setdefault(node.name, []).append(node)
    return found


def asserts(module: str, function: Function, seen: frozenset[Function] = frozenset()) -> bool:
    """Tell whether a function asserts something, itself or by what it calls of the tests."""
    names = imported(module)
    for node in ast.walk(function):
        if isinstance(node, ast.Assert):
            return True
        if not isinstance(node, ast.Call):
            continue
        called = dotted(node.func)
        first, _, rest = called.partition(".")
        full = names.get(first, "") + ("." + rest if rest else "")
        last = called.rpartition(".")[2]
        if last in ASSERTING or full.startswith("numpy.testing"):
            return True
        where, _, name = full.rpartition(".")
        home = where if where in FILES else module
        for inner in functions(home).get(name if home == where else last, []):
            if inner not in seen and asserts(home, inner, seen | {function}):
                return True
    return False


def test_every_test_asserts_something() -> None:
    wrong = [
        f"{module}: {name}"
        for module in FILES
        if module.rpartition(".")[2].startswith("test_")
        for name, found in functions(module).items()
        if name.startswith("test_") and not all(asserts(module, function) for function in found)
    ]
    assert not wrong, "\n".join(wrong)


def test_every_test_has_a_quick_case_or_says_why_not(request: pytest.FixtureRequest) -> None:
    """Of what was collected; `exhaustive(reason=...)` on a whole test says why."""
    assert request.config.stash[WITHOUT_QUICK_CASE] == []


def test_what_is_private() -> None:
    assert private("_a")
    assert private("cordicc.ir._size")
    assert not private("cordicc._repr_svg_")
    assert not private("cordicc.ir.size")
    assert not private("values._replace")
