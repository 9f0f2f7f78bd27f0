"""The report in a real browser: offline, interactive, by keyboard, in the dark, in print, without scripts."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest

from cordicc.backends.pictures import wiring
from cordicc.plan.model import Plan
from tests.support.browser.chromium import Page, script

LIT = script("lit")

CONTRASTS = script("contrasts")


def reached(plan: Plan, box: str) -> set[str]:
    """Return the boxes on the ways from inputs to a box and from there to outputs."""
    pairs = {(net.source.box, sink.box) for net in wiring.nets(plan) for sink in net.sinks}
    found = {box}
    for forward in (True, False):
        side = {box}
        while more := {pair[forward] for pair in pairs if pair[not forward] in side} - side:
            side |= more
        found |= side
    return found


def open_report(page: Page, path: Path, **how: object) -> None:
    page.requests()
    page.complaints()
    page.open(path, **how)  # type: ignore[arg-type]


def test_nothing_is_fetched_and_nothing_complains(
    page: Page, wheel_report: Path, shared_report: Path
) -> None:
    for path in (wheel_report, shared_report):
        open_report(page, path)
        page.point_at("[data-what=datapath] g[data-id^='op.']")
        assert page.requests() == [path.as_uri()]
        assert page.complaints() == []


@pytest.mark.parametrize("width", [1366, 1024])
def test_it_fits_a_laptop(page: Page, wheel_report: Path, puma_report: Path, width: int) -> None:
    for path in (wheel_report, puma_report):
        open_report(page, path, size=(width, 768))
        assert page.ask("return document.documentElement.scrollWidth") <= width
        cut = "(e) => e.scrollWidth > e.clientWidth"
        assert page.ask(f"return [...document.querySelectorAll('.wide')].filter({cut}).length") == 0


def test_pictures_stay_legible_on_a_laptop(page: Page, puma_report: Path) -> None:
    open_report(page, puma_report)
    scales = page.ask(
        "return [...document.querySelectorAll('.wide svg')].map("
        "(e) => e.getBoundingClientRect().width / e.viewBox.baseVal.width)"
    )
    assert min(scales) > 0.85


def test_formulas_are_set_without_scripts(page: Page, wheel_report: Path) -> None:
    open_report(page, wheel_report, scripts=False)
    boxes = page.command(
        "Runtime.evaluate",
        returnByValue=True,
        expression="""(() => {
          const power = document.querySelector(".equations msup, .equations msubsup");
          const parts = [power.firstElementChild, power.lastElementChild];
          const [base, exponent] = parts.map((e) => e.getBoundingClientRect());
          const raised = exponent.bottom < base.bottom;
          return { raised, small: exponent.height < base.height, wide: base.width };
        })()""",
    )["result"]["value"]
    assert boxes["raised"]
    assert boxes["small"]
    assert boxes["wide"] > 3


def test_without_scripts_all_is_there(page: Page, wheel: Plan, wheel_report: Path) -> None:
    open_report(page, wheel_report, scripts=False)
    text = page.driver.find_element("css selector", "main").text
    for operation in wheel.operations:
        assert operation.id in text
    assert not page.driver.find_elements("css selector", ".tools")
    assert page.driver.find_elements("css selector", "[data-id] > title")


@pytest.mark.parametrize("what", ["datapath", "schedule"])
def test_pointing_shows_what_it_is_and_its_way(
    page: Page, wheel: Plan, wheel_report: Path, what: str
) -> None:
    open_report(page, wheel_report)
    page.point_at(f"[data-what={what}] [data-id='op.o4']")
    panel = page.driver.find_element("css selector", ".about")
    assert panel.is_displayed()
    for part in ("o4: implicit circular, branch −", "cau1, implicit CAU", "7 to 55", "residual of at most"):
        assert part in panel.text
    assert panel.find_elements("css selector", "math")
    assert set(page.ask(LIT, "datapath")) == reached(wheel, "op.o4")
    drawn = {box for box in reached(wheel, "op.o4") if box.startswith(("op.", "fifo."))}
    assert set(page.ask(LIT, "schedule")) == drawn
    page.point_at("h1")
    assert not panel.is_displayed()
    assert page.ask(LIT, "datapath") == []


def test_the_way_goes_on_in_other_rows(page: Page, puma: Plan, puma_report: Path) -> None:
    open_report(page, puma_report)
    operation = next(o for o in puma.operations if o.op == "implicit")
    page.point_at(f"[data-what=datapath] [data-id='op.{operation.id}']")
    assert set(page.ask(LIT, "datapath")) == reached(puma, f"op.{operation.id}")
    rows = "[...document.querySelectorAll('[data-what=datapath] .wide')]"
    assert page.ask(f"return {rows}.filter((e) => e.querySelector('path.lit')).length") >= 3


def test_wires_that_lead_elsewhere_stay_dark(page: Page, wheel: Plan, wheel_report: Path) -> None:
    open_report(page, wheel_report)
    page.point_at("[data-what=datapath] [data-id='out.beta']")
    paths = "[...document.querySelectorAll('[data-what=datapath] path[data-from].lit')]"
    lit = page.ask(f"return {paths}.map((e) => e.dataset.to)")
    assert lit
    assert {box for each in lit for box in each.split()} <= reached(wheel, "out.beta")


def test_by_keyboard(page: Page, wheel_report: Path) -> None:
    from selenium.webdriver.common.keys import Keys

    open_report(page, wheel_report)
    focused = "return document.activeElement.dataset.id ?? null"
    for _ in range(60):
        page.keys(Keys.TAB)
        if page.ask(focused):
            break
    assert page.ask(focused) == "in.S"
    panel = page.driver.find_element("css selector", ".about")
    assert "input S" in panel.text
    page.keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert page.ask(focused) == "op.o1"
    assert "o1: mul" in panel.text
    page.keys(Keys.END)
    assert page.ask(focused).startswith("out.")
    page.keys(Keys.HOME, Keys.ARROW_RIGHT, Keys.ENTER, Keys.TAB)
    assert panel.is_displayed()  # kept
    page.keys(Keys.ESCAPE)
    assert not panel.is_displayed()
    stops = "return document.querySelectorAll('[data-what=datapath] [data-id][tabindex=\"0\"]').length"
    assert page.ask(stops) == 1


def test_the_panel_does_not_cover_what_it_is_about(page: Page, wheel_report: Path) -> None:
    open_report(page, wheel_report)
    for block in ("start", "end"):
        page.ask(
            """
            const element = document.querySelector("[data-what=schedule] [data-id='op.o11']");
            element.scrollIntoView({ block: arguments[0], behavior: "instant" });
            element.dispatchEvent(new PointerEvent("pointerenter"));
            """,
            block,
        )
        free = page.ask(
            """
            const [part, panel] = ["[data-what=schedule] [data-id='op.o11']", ".about"].map(
              (selector) => document.querySelector(selector).getBoundingClientRect());
            return panel.height > 0 && (part.bottom <= panel.top || part.top >= panel.bottom);
            """
        )
        assert free, block


def test_a_click_keeps_and_releases(page: Page, wheel_report: Path) -> None:
    open_report(page, wheel_report)
    selector = "[data-what=datapath] [data-id='op.o5']"
    page.point_at(selector)
    page.driver.find_element("css selector", selector).click()
    page.point_at("h1")
    panel = page.driver.find_element("css selector", ".about")
    assert "o5:" in panel.text
    panel.find_element("css selector", "button").click()
    assert not panel.is_displayed()


def test_size_buttons(page: Page, wheel_report: Path) -> None:
    open_report(page, wheel_report)
    width = "return document.querySelector('[data-what=datapath] svg').getBoundingClientRect().width"
    fitted = page.ask(width)
    larger, fit = (
        f"[data-what=datapath] button[aria-label='{name}']" for name in ("Larger", "Fit to the page")
    )
    for selector in (larger, larger):
        page.driver.find_element("css selector", selector).click()
    assert page.ask(width) == pytest.approx(fitted * 1.25**2, rel=0.01)
    page.driver.find_element("css selector", fit).click()
    assert page.ask(width) == pytest.approx(fitted)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_contrast(page: Page, wheel_report: Path, shared_report: Path, puma_report: Path, dark: bool) -> None:
    for path in (wheel_report, shared_report, puma_report):
        open_report(page, path, dark=dark)
        assert page.ask(CONTRASTS) == []


def test_dark_mode(page: Page, wheel_report: Path) -> None:
    shades = {}
    for dark in (False, True):
        open_report(page, wheel_report, dark=dark)
        shades[dark] = page.ask(
            "return [getComputedStyle(document.body).backgroundColor, "
            "getComputedStyle(document.querySelector('figure svg > rect')).fill]"
        )
    assert shades[False] == ["rgb(255, 255, 255)"] * 2
    assert shades[True] == ["rgb(20, 24, 29)"] * 2


def test_everything_that_takes_the_focus_has_a_name(page: Page, wheel_report: Path) -> None:
    open_report(page, wheel_report)
    nodes = page.command("Accessibility.getFullAXTree")["nodes"]
    focusable = [
        node
        for node in nodes
        if not node["ignored"]
        and any(p["name"] == "focusable" and p["value"]["value"] for p in node.get("properties", []))
    ]
    roles = {node["role"]["value"] for node in focusable}
    assert {"link", "button", "group"} <= roles
    assert [n["role"]["value"] for n in focusable if not n.get("name", {}).get("value", "").strip()] == []
    described = {node["role"]["value"] for node in nodes}
    assert {"main", "navigation", "heading", "table", "rowheader", "columnheader", "math"} & described >= {
        "main",
        "navigation",
        "heading",
        "table",
    }


def test_headings_and_landmarks(page: Page, wheel_report: Path) -> None:
    open_report(page, wheel_report)
    levels = page.ask("return [...document.querySelectorAll('h1, h2, h3')].map((e) => Number(e.tagName[1]))")
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert page.ask("return document.documentElement.lang") == "en"


def test_print(page: Page, puma_report: Path) -> None:
    open_report(page, puma_report)
    page.media(kind="print")
    gone = "(e) => getComputedStyle(e).display === 'none'"
    assert page.ask(f"return [...document.querySelectorAll('.tools, .about, nav')].every({gone})")
    page.media()
    pdf = page.pdf()
    boxes = {tuple(map(float, box.split())) for box in re.findall(rb"/MediaBox\s*\[([^\]]*)\]", pdf)}
    assert any(box[2] > box[3] for box in boxes), "the pictures are on landscape sheets"
    assert any(box[2] < box[3] for box in boxes)
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) < 25
