"""Whatever the files hold, a command ends in bounded time and memory, with a diagnostic if it fails."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.support.hostile.cases import Case
from tests.support.hostile.catalogue import CASES, QUICK
from tests.support.hostile.running import run
from tests.support.selection import quick

PEAK_BYTES = 1 << 30
IDS = [re.sub(r"\W+", "-", case.name) for case in CASES]


def test_names_are_unique() -> None:
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", quick(CASES, *QUICK), ids=IDS)
def test_ends_well(case: Case, tmp_path: Path) -> None:
    case.lay_out(tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    ended = run(case.arguments, tmp_path)
    assert not ended.crashed, ended.stderr[-2000:]
    assert case.fits(ended.status, ended.codes), (ended.status, ended.stderr[-2000:])
    assert ended.peak_bytes < PEAK_BYTES
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e]", ended.stderr + ended.stdout)
    made = {path.name for path in tmp_path.iterdir()} - before - {".outcome"}
    assert "pwned" not in made
    # What is written is whole or absent, and nothing is left beside.
    assert made <= ({"out", "o.json", "o.svg"} if ended.status == 0 else set())
    if "out" in made:
        assert len(list((tmp_path / "out").iterdir())) == 5
