"""The browser and the pages that its tests share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from cordicc import artefacts, pipeline
from cordicc.pipeline import Options
from cordicc.plan.model import Plan
from cordicc.schedule.request import Limits
from tests.whole.browser.chromium import Page, browser, why_not
from tests.whole.browser.drawn_plans import plan_of


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
    return pipeline.compile_file(examples_dir / "wheel_suspension.yaml", Options()).plan


@pytest.fixture(scope="session")
def wheel_report(wheel: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _written(wheel, tmp_path_factory)


@pytest.fixture(scope="session")
def puma() -> Plan:
    """A large plan, without its accuracy."""
    return plan_of("examples/puma560")


@pytest.fixture(scope="session")
def puma_report(puma: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _written(puma, tmp_path_factory)


@pytest.fixture(scope="session")
def shared_report(examples_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a plan whose operations share units."""
    options = Options(limits=Limits(initiation_interval=8))
    plan = pipeline.compile_file(examples_dir / "quadruped_leg.yaml", options).plan
    return _written(plan, tmp_path_factory)


def _written(plan: Plan, factory: pytest.TempPathFactory) -> Path:
    path = factory.mktemp("report") / "report.html"
    path.write_text(artefacts.report_page(plan), encoding="utf-8")
    return path
