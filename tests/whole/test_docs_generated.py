"""What `docs/generate.py` writes is what is there."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def generate() -> ModuleType:
    spec = importlib.util.spec_from_file_location("generate", DOCS / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.exhaustive(reason="compiles all examples to draw the gallery")
def test_generated_files_are_fresh(generate: ModuleType, request: pytest.FixtureRequest) -> None:
    if request.config.getoption("--update-golden"):
        generate.main()
    for path, text in generate.generated().items():
        assert path.read_text(encoding="utf-8") == text, f"run python docs/generate.py: {path.name} differs"
