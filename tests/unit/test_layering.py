"""Each layer imports only to the right; the five in the middle do not import one another."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "cordicc"

RANKS = [
    {"cli", "__main__"},
    {"cli_compare"},
    {"cli_plans", "cli_schedule", "cli_simulate", "cli_study"},
    {"cli_common"},
    {"console"},
    {"explain", "plan_diff"},
    {"api", "explore", "summary", "trace", "sequence_text"},
    {"pipeline"},
    {"guard_bits", "word_lengths", "within_error"},
    {"checks", "observation", "certify", "copies"},
    {"poles"},
    {"record", "typesetting"},
    {"frontend", "rewrite", "schedule", "emulate", "backends"},
    {"plan", "plan_check", "plan_json"},
    {"targets"},
    {"ir"},
    {"arith"},
    {"codes", "diagnostics", "files", "folders", "sheet"},
]
RANK = {layer: rank for rank, layers in enumerate(RANKS) for layer in layers}
TOGETHER = [
    {"cli", "__main__"},
    {"plan", "plan_json"},
    {"plan", "plan_check"},
    {"diagnostics", "files"},
    {"diagnostics", "folders"},
    {"diagnostics", "sheet"},
    {"files", "folders"},
]


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("cordicc."):
            found.add(node.module.split(".")[1])
        elif isinstance(node, ast.ImportFrom) and node.module == "cordicc":
            found |= {alias.name for alias in node.names} & set(RANK)
        elif isinstance(node, ast.Import):
            found |= {alias.name.split(".")[1] for alias in node.names if alias.name.startswith("cordicc.")}
    return found


@pytest.mark.parametrize("path", sorted(ROOT.rglob("*.py")), ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_only_to_the_right(path: Path) -> None:
    layer = path.relative_to(ROOT).parts[0].removesuffix(".py")
    if layer == "__init__":
        return
    for other in imports(path) - {layer}:
        allowed = RANK[other] > RANK[layer] or {layer, other} in TOGETHER
        assert allowed, f"{path.name}: {layer} must not import {other}"


def test_modules_stay_small() -> None:
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in ROOT.rglob("*.py")}
    assert not {path.name: length for path, length in lengths.items() if length >= 400}
