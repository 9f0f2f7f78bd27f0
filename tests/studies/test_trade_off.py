"""`cordicc draw` and the trade-off in the report: formats, rows, and what is said where something lacks."""

from __future__ import annotations

import builtins
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from cordicc.api import Picture
from cordicc.base.diagnostics import InvalidInput
from cordicc.cli.explore import report_with
from cordicc.ir.text import parse_graph
from cordicc.plan.file import parse
from cordicc.studies import trade_off
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.selection import slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("leg")
    assert run("compile", EXAMPLES / "quadruped_leg.yaml", "-o", made).exit_code == 0
    return made


def width_of(svg: str) -> float:
    return float(re.search(r'<svg [^>]*width="([\d.]+)"', svg)[1])  # type: ignore[index]


class TestDraw:
    @pytest.mark.parametrize("view", [slow("datapath"), "schedule", slow("graph")])
    def test_png_and_pdf(self, folder: Path, tmp_path: Path, view: str) -> None:
        try:
            import cairosvg  # noqa: F401
        except (ImportError, OSError) as error:
            pytest.skip(f"CairoSVG cannot be used: {error}")
        for suffix, start in ((".png", b"\x89PNG"), (".pdf", b"%PDF")):
            files = [tmp_path / f"{name}{suffix}" for name in "ab"]
            for file in files:
                result = run("draw", folder / "plan.json", "--view", view, "-o", file)
                assert (result.exit_code, result.stderr) == (0, "")
            assert files[0].read_bytes().startswith(start)
            assert files[0].read_bytes() == files[1].read_bytes()
            assert b"CreationDate" not in files[0].read_bytes()

    @pytest.mark.parametrize(
        "error", [ImportError("no module"), OSError("no library called cairo\nwas found")]
    )
    def test_without_the_library(self, folder: Path, tmp_path: Path, monkeypatch, error) -> None:
        real = builtins.__import__

        def lacking(name, *arguments, **keywords):
            if name == "cairocffi":
                raise error
            return real(name, *arguments, **keywords)

        monkeypatch.setattr(builtins, "__import__", lacking)
        result = run("draw", folder / "plan.json", "-o", tmp_path / "a.png")
        assert result.exit_code == 2
        assert "error[E650]: PNG pictures take CairoSVG, which cannot be used: no " in result.stderr
        assert "pip install 'cordicc[pictures]'" in result.stderr
        assert not list(tmp_path.iterdir())

    @pytest.mark.parametrize(
        ("width", "height", "said"),
        [
            (16_384, 300, "32,768 x 600 pixels, of which a side has at most 32,767"),
            (300, 20_000, "600 x 40,000 pixels, of which a side has at most 32,767"),
            (16_000, 16_000, "32,000 x 32,000 pixels, of which there are at most 268,435,456"),
        ],
    )
    def test_a_png_has_a_limit(self, monkeypatch, width: int, height: int, said: str) -> None:
        """It is told before Cairo is asked."""
        monkeypatch.setitem(sys.modules, "cairosvg", None)
        picture = Picture(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"/>')
        with pytest.raises(InvalidInput) as caught:
            picture.converted(".png")
        (finding,) = caught.value.diagnostics
        assert (finding.code, finding.message) == ("E654", f"as a PNG the picture would have {said}")
        assert "write .svg or .pdf, or fold" in str(finding.hint)
        with pytest.raises(InvalidInput, match="E650"):
            picture.converted(".pdf")
        assert picture.converted(".svg") == picture.svg

    def test_an_unknown_format(self, folder: Path, tmp_path: Path) -> None:
        result = run("draw", folder / "plan.json", "-o", tmp_path / "a.gif")
        assert result.exit_code == 2
        assert "error[E651]: pictures are written as .svg, .png, .pdf, not '.gif'" in result.stderr

    def test_rows(self, folder: Path) -> None:
        narrow = run("draw", folder / "plan.json", "--width", 700).stdout
        wide = run("draw", folder / "plan.json", "--width", 0).stdout
        assert width_of(narrow) <= 760 < width_of(wide)
        assert narrow.count("start cycle") > wide.count("start cycle") == 1


class TestTradeOff:
    @pytest.fixture
    def front(self, folder: Path) -> trade_off.Front:
        plan = parse((folder / "plan.json").read_text(encoding="utf-8"), "plan.json")
        counts = {"implicit": 3}
        points = (
            trade_off.Point("auto", 1, 3, 3, 107, 40, counts, dict(plan.bounds), dict(plan.optimal)),
            trade_off.Point("auto", 8, 1, 1, 120, 12, {"implicit": 1}, dict(plan.bounds), dict(plan.optimal)),
        )
        title = "Trade-off of quadruped-leg"
        return trade_off.Front(plan.name, title, "kinematic", 1, points, 9, plan.problem.program)

    def test_the_report_of_the_same_problem_gets_it(self, folder: Path, front) -> None:
        text = report_with(front, folder)["report.html"]
        assert 'href="#trade-off"' in text
        assert "Latency in cycles over CAUs" in text

    def test_the_report_of_another_problem_stays(self, folder: Path, front, capsys) -> None:
        assert report_with(replace(front, program=parse_graph("%0 = input[name=x]\n")), folder) == {}
        assert "warning[W722]" in capsys.readouterr().err

    def test_so_does_that_of_equal_values_by_other_equations(self, folder: Path, front, capsys) -> None:
        nodes = tuple(replace(node, origin="another") for node in front.program.nodes)
        assert report_with(replace(front, program=replace(front.program, nodes=nodes)), folder) == {}
        assert "warning[W722]" in capsys.readouterr().err

    def test_no_plan_or_a_broken_one(self, tmp_path: Path, front, capsys) -> None:
        assert report_with(front, tmp_path) == {}
        assert capsys.readouterr().err == ""
        (tmp_path / "plan.json").write_text("{}")
        assert report_with(front, tmp_path) == {}
        assert "was left as it is: not a plan" in capsys.readouterr().err


def test_unknown_view(folder: Path) -> None:
    from cordicc.api import load_plan

    with pytest.raises(InvalidInput, match="E652"):
        load_plan(folder / "plan.json").picture("front")
