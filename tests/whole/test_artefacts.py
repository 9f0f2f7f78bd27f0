"""The table of artefacts: what is always written, what if it is asked for, and who takes choices from it."""

import pytest

import cordicc
from cordicc.artefacts import ARTEFACTS, ON_REQUEST, VIEWS, Written, artefacts, picture
from cordicc.base.diagnostics import InvalidInput
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled


@pytest.fixture(scope="module")
def plan() -> cordicc.Plan:
    return compiled(EXAMPLES / "wheel_beta.yaml", target="fixed24", certify=False, effort=0.1)


@pytest.mark.parametrize("name", ARTEFACTS)
def test_each_is_written(plan: cordicc.Plan, name: str) -> None:
    files = plan.emit(name)
    assert all(files.values())
    if (file := ARTEFACTS[name].file) is not None:
        assert list(files) == [file]


def test_a_folder_has_what_is_always_written_and_what_is_asked_for(plan: cordicc.Plan) -> None:
    always = [each.file for each in ARTEFACTS.values() if each.written is Written.ALWAYS]
    assert list(artefacts(plan)) == always
    asked = [file for name in ON_REQUEST for file in plan.emit(name)]
    assert list(artefacts(plan, ON_REQUEST)) == [*always, *asked]
    assert list(plan.emit("c")) == ["wheel_beta.c", "wheel_beta.h"]


def test_a_view_is_the_picture_of_the_folder(plan: cordicc.Plan) -> None:
    files = artefacts(plan)
    assert {view: picture(plan, view, 1240) for view in VIEWS if f"{view}.svg" in files} == {
        view: files[f"{view}.svg"] for view in VIEWS if f"{view}.svg" in files
    }


def test_the_commands_know_the_table() -> None:
    said = run("compile", "--help").stdout
    for each in ARTEFACTS.values():
        assert each.written is not Written.ALWAYS or str(each.file) in said
    assert f"[{'|'.join(ON_REQUEST)}]" in said
    assert f"[{'|'.join(VIEWS)}]" in run("draw", "--help").stdout


def test_an_unknown_name(plan: cordicc.Plan) -> None:
    with pytest.raises(InvalidInput, match="E653"):
        plan.emit("vhdl")
