"""The structure of the package: nine floors, no circle, names that occur once."""

import ast
from collections import Counter, defaultdict
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

from tests.support.imports import statements
from tests.support.paths import PACKAGE as ROOT

FLOORS = (
    "cli",
    "api | studies",
    "pipeline | artefacts | readback",
    "certify | precision",
    "frontend | rewrite | schedule | emulate | backends",
    "plan | expressions",
    "ir | targets",
    "arith",
    "base",
)
"""Each imports from those below only; what stands on one floor does not import its neighbours."""

FLOOR = {name: floor for floor, names in enumerate(FLOORS) for name in names.split(" | ")}
BOTH_WAYS = {
    ("frontend", "frontend/plain"): "the loader calls it; it works with the scope, trees and lowering of all",
    ("frontend", "frontend/robots"): "the reader of items calls it; it reads keys and trees as all do",
    (
        "frontend",
        "frontend/solving",
    ): "the reader of solve calls it; it works with the scope and lowering of all",
    ("ir", "ir/meaning"): "a problem has ranges, which are intervals; the meanings are of graphs",
}
"""Pairs of folders that import each other, and why."""

LONGEST = 400
"""Lines of a module."""

PATHS = sorted(ROOT.rglob("*.py"))
MODULES = {".".join(("cordicc", *path.relative_to(ROOT).with_suffix("").parts)): path for path in PATHS}


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imported(tree: ast.Module) -> set[str]:
    """The modules of the package that a module imports, at its start or later."""
    found = set()
    for node in statements(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "cordicc":
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (inner & set(MODULES)) or {str(node.module)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name.split(".")[0] == "cordicc"}
    return found


def test_every_import_runs_down() -> None:
    wrong = []
    for name, path in MODULES.items():
        here = path.relative_to(ROOT).parts[0].removesuffix(".py")
        for other in imported(parsed(path)) if here not in ("__init__", "__main__") else ():
            there = (*other.split("."), "__init__")[1]
            if here != there and there != "__init__" and FLOOR[there] <= FLOOR[here]:
                wrong.append(f"{name} must not import {other}")
    assert not wrong


def test_no_circle() -> None:
    order = TopologicalSorter({name: imported(parsed(path)) for name, path in MODULES.items()}).static_order()
    assert set(MODULES) <= set(order)  # a circle is a CycleError


def test_folders_import_one_way() -> None:
    folder = {name: path.parent.relative_to(ROOT).as_posix() for name, path in MODULES.items()}
    pairs = {
        (folder[name], folder[other])
        for name, path in MODULES.items()
        for other in imported(parsed(path)) & set(MODULES)
        if "." not in (folder[name], folder[other])  # the root's modules stand on floors of their own
    }
    assert {(a, b) for a, b in pairs if a < b and (b, a) in pairs} == set(BOTH_WAYS)


def test_six_modules_at_the_root() -> None:
    names = {path.stem for path in ROOT.glob("*.py")}
    assert names == {"__init__", "__main__", "api", "pipeline", "artefacts", "readback"}


def test_no_two_modules_of_one_name() -> None:
    count = Counter(path.stem for path in PATHS if path.name != "__init__.py")
    assert not [name for name, times in count.items() if times > 1]


def test_no_two_public_classes_of_one_name() -> None:
    places = defaultdict(list)
    for path in PATHS:
        for node in parsed(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(str(path.relative_to(ROOT)))
    assert not {name: found for name, found in places.items() if len(found) > 1}


def test_every_folder_says_what_belongs_in_it() -> None:
    texts = {path: ast.get_docstring(parsed(path.parent / "__init__.py")) or "" for path in PATHS}
    short = {str(path.parent) for path, text in texts.items() if len(text) < 20}
    assert not short


def test_modules_stay_small() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in PATHS}
    assert not {path.name: length for path, length in lengths.items() if length >= LONGEST}
