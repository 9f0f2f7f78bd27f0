"""Fixtures and options that all tests share."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

from tests.support import plans, selection

TESTS = Path(__file__).resolve().parent

Golden = Callable[[str, str], None]
"""Compares a text with the golden file of that path below `tests/whole/golden`."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="rewrite the golden files with what the tests produce; read the difference before you commit it",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Choose the number of examples, and make the folder of compiled plans.

    Workers of xdist start later, with the folder in their environment.
    """
    # The same examples in every run: a failure in CI is one that everybody can repeat.
    quick = "not exhaustive" in config.option.markexpr
    settings.load_profile("quick" if quick else "everything")
    if plans.FOLDER not in os.environ:
        os.environ[plans.FOLDER] = tempfile.mkdtemp(prefix="cordicc-plans-")
        config.add_cleanup(lambda: shutil.rmtree(os.environ.pop(plans.FOLDER)))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Note, before any is deselected, which tests have no quick case."""
    config.stash[selection.WITHOUT_QUICK_CASE] = selection.without_quick_case(items)


@pytest.fixture(scope="session")
def corpus_dir() -> Path:
    """The public corpus: problems, inputs and expected outputs."""
    return TESTS / "whole" / "corpus"


@pytest.fixture(scope="session")
def examples_dir() -> Path:
    """The examples that ship with the project."""
    return TESTS.parent / "examples"


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Golden:
    """`golden("stage/name.txt", text)` compares with that golden file; `--update-golden` rewrites it."""
    update = request.config.getoption("--update-golden")

    def compare(path: str, text: str) -> None:
        file = TESTS / "whole" / "golden" / path
        if update:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8", newline="")
            return
        if not file.exists():
            pytest.fail(f"no golden file {path}: run pytest with --update-golden", pytrace=False)
        expected = file.read_bytes().decode("utf-8")
        assert text == expected, f"differs from golden file {path}; if that is right: pytest --update-golden"

    return compare
