"""The structure of the package: nine floors, no circle, names that occur once."""

import ast
from collections import Counter, defaultdict
from graphlib import TopologicalSorter

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
LONGEST = 400
"""Lines of a module."""

TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(ROOT.rglob("*.py"))}
MODULES = {".".join(("cordicc", *path.relative_to(ROOT).with_suffix("").parts)): path for path in TREES}


def imported(tree: ast.Module) -> set[str]:
    """The modules of the package that a module imports, at its start or later."""
    found = set()
    for node in ast.walk(tree):
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
        for other in imported(TREES[path]) if here not in ("__init__", "__main__") else ():
            there = (*other.split("."), "__init__")[1]
            if here != there and there != "__init__" and FLOOR[there] <= FLOOR[here]:
                wrong.append(f"{name} must not import {other}")
    assert not wrong


def test_no_circle() -> None:
    TopologicalSorter({name: imported(TREES[path]) for name, path in MODULES.items()}).prepare()


def test_six_modules_at_the_root() -> None:
    names = {path.stem for path in ROOT.glob("*.py")}
    assert names == {"__init__", "__main__", "api", "pipeline", "artefacts", "readback"}


def test_no_two_modules_of_one_name() -> None:
    count = Counter(path.stem for path in TREES if path.name != "__init__.py")
    assert not [name for name, times in count.items() if times > 1]


def test_no_two_public_classes_of_one_name() -> None:
    places = defaultdict(list)
    for path, tree in TREES.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(str(path.relative_to(ROOT)))
    assert not {name: found for name, found in places.items() if len(found) > 1}


def test_every_folder_says_what_belongs_in_it() -> None:
    texts = {path: ast.get_docstring(TREES[path.parent / "__init__.py"]) or "" for path in TREES}
    short = {str(path.parent) for path, text in texts.items() if len(text) < 20}
    assert not short


def test_modules_stay_small() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in TREES}
    assert not {path.name: length for path, length in lengths.items() if length >= LONGEST}
