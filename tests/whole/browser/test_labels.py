"""Labels as the browser sets them: none meets another one, is cut, or leaves its box, in any picture."""

from __future__ import annotations

from pathlib import Path

import pytest

from cordicc import artefacts
from tests.support.browser.chromium import Page, script
from tests.support.browser.drawn_plans import PLANS, plan_of
from tests.support.selection import quick

FONTS = ("", "'DejaVu Sans', sans-serif")
"""As it is, and the widest of the common fonts."""

QUICK = [name for name in PLANS if name.startswith("hard/")]
QUICK += ["random, 40 units", "examples/wheel_suspension", "examples/planar_2r"]
"""Plans made by hand, larger than those of most examples, and two that other tests compile too."""

FINDINGS = script("findings")


@pytest.mark.parametrize("view", artefacts.VIEWS)
@pytest.mark.parametrize("name", quick(PLANS, *QUICK))
def test_labels(page: Page, tmp_path: Path, name: str, view: str) -> None:
    file = tmp_path / "picture.html"
    # In a page: a picture of its own is given the size of the window.
    file.write_text(f"<!DOCTYPE html><meta charset=utf-8>{artefacts.picture(plan_of(name), view)}", "utf-8")
    page.open(file)
    for font in FONTS:
        assert page.ask(FINDINGS, font, view != "schedule") == []


def test_a_finding_is_found(page: Page, tmp_path: Path) -> None:
    file = tmp_path / "picture.html"
    places = ((5, 20, "long label"), (30, 22, "another"), (190, 60, "cut"))
    texts = "".join(f'<text x="{x}" y="{y}">{text}</text>' for x, y, text in places)
    rect = '<rect x="20" y="80" width="20" height="12"/>'
    box = f'<g data-id="a">{rect}<text x="18" y="90">wide</text></g>'
    file.write_text(f'<!DOCTYPE html><svg width="200" height="100">{texts}{box}</svg>', "utf-8")
    page.open(file)
    assert page.ask(FINDINGS, "", True) == ["cut is cut", "long label meets another", "wide leaves its box"]
