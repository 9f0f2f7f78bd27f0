"""The mark of files that cordicc made: it is there, it tells changes, and every artefact can carry one."""

from __future__ import annotations

import ast
import json
from xml.etree import ElementTree

import pytest

from cordicc.artefacts import ARTEFACTS
from cordicc.base.seals import is_csv, is_sealed, sealed, vouches
from tests.support.paths import EXAMPLES
from tests.support.plans import planned

TEXTS = {
    "simulate.py": "print('a')\n",
    "a.svg": '<svg xmlns="http://www.w3.org/2000/svg"/>\n',
    "a.c": "int a;\n",
    "rtl/a.v": "module a; endmodule\n",
    "rtl/Makefile": "sim:\n",
    "vectors/in.hex": "00\n",
}


@pytest.mark.parametrize("name", TEXTS)
def test_a_changed_file_is_told(name: str) -> None:
    marked = sealed(name, TEXTS[name])
    assert marked.startswith(TEXTS[name])
    assert marked.count("\n") == TEXTS[name].count("\n") + 1
    data = marked.encode()
    assert is_sealed(name, data)
    assert is_sealed(name, data.replace(b"\n", b"\r\n"))
    for changed in (b" " + data, data + b"\n", data[:-1], data.replace(b"a", b"b", 1), b"", data * 2):
        assert not is_sealed(name, changed)
    assert not is_sealed(name, TEXTS[name].encode())


def test_marks_are_comments() -> None:
    script = "simulate.py"
    assert ast.dump(ast.parse(sealed(script, TEXTS[script]))) == ast.dump(ast.parse(TEXTS[script]))
    assert len(ElementTree.fromstring(sealed("a.svg", TEXTS["a.svg"]))) == 0


@pytest.mark.parametrize(
    ("content", "own"),
    [
        ('{"format": "cordicc-plan"}', True),
        ('{"format": "other"}', False),
        ('{"note": "cordicc-plan"}', False),
        ('["cordicc-plan"]', False),
        ("cordicc-plan", False),
        ("[" * 100_000, False),
        ("", False),
    ],
)
def test_json_says_what_it_is(content: str, own: bool) -> None:
    assert is_sealed("plan.json", content.encode()) == own


def test_a_name_without_a_kind_of_comment_is_refused() -> None:
    with pytest.raises(ValueError, match=r"not known how 'a.png' is marked"):
        sealed("a.png", "")


@pytest.mark.parametrize("name", ARTEFACTS)
def test_every_artefact_is_marked(name: str) -> None:
    """One that is added is marked by its file's name, or brings a kind of comment with it."""
    texts = planned(EXAMPLES / "planar_2r.yaml", target="fixed24").emit(name)
    for file, text in texts.items():
        if is_csv(file):
            described = texts[file.removesuffix("csv") + "json"].encode()
            assert vouches(described, text.encode())
            assert vouches(described, text.replace("\n", "\r\n").encode())
            assert not vouches(described, f"{text} ".encode())
            assert not vouches(described.replace(b"cordicc-", b"", 1), text.encode())
            continue
        assert is_sealed(file, text.encode())
        if file.endswith(".json"):
            assert json.loads(text)["format"].startswith("cordicc-")
