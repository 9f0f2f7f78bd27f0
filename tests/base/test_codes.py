"""The registry of codes is what the source raises, and each is explained."""

import ast
import re
from pathlib import Path

import pytest

from cordicc.base.codes import CODES, HELP
from tests.support.paths import PACKAGE

CODE = re.compile(r"[EW][0-9]{3}")


def raised() -> set[str]:
    """Return every text of the source, the registry apart, that is a code."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        if path != PACKAGE / "base" / "codes.py":
            tree = ast.parse(path.read_text(encoding="utf-8"))
            constants = (n.value for n in ast.walk(tree) if isinstance(n, ast.Constant))
            found |= {text for text in constants if isinstance(text, str) and CODE.fullmatch(text)}
    return found


def test_every_code_that_is_raised_is_registered_and_the_other_way_round() -> None:
    assert raised() == set(CODES)


def test_every_code_has_a_meaning_and_a_remedy() -> None:
    assert set(CODES) == set(HELP)
    for code, meaning in CODES.items():
        assert CODE.fullmatch(code)
        assert meaning[0].islower() or meaning.startswith("--"), code
        assert not meaning.endswith(".")
        assert HELP[code].endswith(".")
    assert list(CODES) == list(HELP) == sorted(CODES)


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: p.name)
def test_docstrings_name_codes_that_exist(path: Path) -> None:
    named = set(re.findall(r"\b[EW][1-8][0-9]{2}\b", path.read_text(encoding="utf-8")))
    assert named <= set(CODES)
