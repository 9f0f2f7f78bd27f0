"""Invalid problem files, and the exact diagnostics they get.

Each `errors/NAME.yaml` has an `errors/NAME.expected` with everything that is shown for it.  Set
CORDICC_UPDATE=1 to write the expected files anew, and read the difference.
"""

import os
import re
from pathlib import Path

import pytest

from cordicc.base.codes import CODES
from cordicc.base.diagnostics import InvalidInput
from cordicc.frontend.load import load_problem

CASES = sorted((Path(__file__).parent / "errors").glob("*.yaml"))


def shown(path, monkeypatch):
    """Return all diagnostics of a file, under its base name."""
    monkeypatch.chdir(path.parent)
    try:
        diagnostics = load_problem(path.name).warnings
    except InvalidInput as error:
        diagnostics = error.diagnostics
    return "".join(d.render() + "\n" for d in diagnostics)


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.stem)
def test_case(path, monkeypatch):
    text = shown(path, monkeypatch)
    expected = path.with_suffix(".expected")
    if os.environ.get("CORDICC_UPDATE"):
        expected.write_text(text, encoding="utf-8")
    assert text == expected.read_text(encoding="utf-8")
    assert set(re.findall(r": (?:error|warning)\[([A-Z0-9]+)\]", text)) <= set(CODES)


def test_there_are_cases():
    assert len(CASES) >= 40


@pytest.mark.parametrize("name", ["missing.yaml", "a\0b.yaml", "."])
def test_unreadable(name, tmp_path):
    with pytest.raises(InvalidInput) as caught:
        load_problem(tmp_path / name)
    assert [d.code for d in caught.value.diagnostics] == ["E100"]


def test_large_file(tmp_path):
    path = tmp_path / "large.yaml"
    path.write_bytes(b"#" * ((1 << 20) + 1))
    with pytest.raises(InvalidInput) as caught:
        load_problem(path)
    assert "larger than 1 MiB" in str(caught.value)


def test_utf16_and_byte_order_mark(tmp_path):
    text = "inputs: {x: [0, 1]}\nequations: [y = x]\n"
    path = tmp_path / "p.yaml"
    path.write_text(text, encoding="utf-16")
    with pytest.raises(InvalidInput):
        load_problem(path)
    path.write_text(text, encoding="utf-8-sig")
    assert [d.code for d in load_problem(path).warnings] == ["W101"]


def test_number_of_errors_is_limited(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("inputs: {x: [0, 1]}\nequations:\n" + "".join(f"- y{i} = z{i}\n" for i in range(500)))
    with pytest.raises(InvalidInput) as caught:
        load_problem(path)
    assert len(caught.value.diagnostics) == 101
    assert caught.value.diagnostics[-1].code == "E299"
