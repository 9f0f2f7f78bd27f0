"""The browser and the pages that its tests share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from cordicc import artefacts
from cordicc.plan.model import Plan
from tests.support.browser.chromium import Page, browser, why_not
from tests.support.browser.drawn_plans import plan_of
from tests.support.plans import compiled


@pytest.fixture(scope="session")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A browser, or the reason why there is none."""
    if reason := why_not():
        pytest.skip(reason)
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture(scope="session")
def wheel(examples_dir: Path) -> Plan:
    """A small plan with its accuracy."""
    return compiled(examples_dir / "wheel_suspension.yaml")


@pytest.fixture(scope="session")
def wheel_report(wheel: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _written(wheel, tmp_path_factory)


@pytest.fixture(scope="session")
def puma() -> Plan:
    """A large plan, without its accuracy, that takes no search."""
    return plan_of("random, 40 units")


@pytest.fixture(scope="session")
def puma_report(puma: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _written(puma, tmp_path_factory)


@pytest.fixture(scope="session")
def shared_report(examples_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a plan whose operations share units."""
    return _written(compiled(examples_dir / "quadruped_leg.yaml", ii=8), tmp_path_factory)


def _written(plan: Plan, factory: pytest.TempPathFactory) -> Path:
    path = factory.mktemp("report") / "report.html"
    path.write_text(artefacts.report_page(plan), encoding="utf-8")
    return path
