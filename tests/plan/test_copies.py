"""Several instances of a problem in one plan."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import cordicc
from cordicc.cli.main import main
from cordicc.ir.sampling import draw
from cordicc.ir.text import parse_graph, print_graph
from cordicc.plan.copies import copied, replicated
from cordicc.plan.file import dump, parse
from cordicc.plan.verify import verify
from cordicc.schedule.place import scheduling_problem
from cordicc.targets.target import CAU_KINDS
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled, planned
from tests.support.selection import slow


@pytest.fixture(scope="module", params=["wheel_beta", slow("wheel_suspension")])
def problem(request: pytest.FixtureRequest) -> Path:
    return EXAMPLES / f"{request.param}.yaml"


@pytest.fixture(scope="module")
def pair(problem: Path) -> cordicc.Plan:
    return compiled(problem, ii=4, copies=2, effort=0.1)


def test_copies_share_the_units(pair: cordicc.Plan, problem: Path) -> None:
    one = planned(problem, ii=4)
    verify(pair)
    assert len(pair.operations) == 2 * len(one.operations)
    counts = [sum(o.kind == kind for o in pair.operations) for kind in CAU_KINDS]
    assert pair.processors()["total"] == sum(-(-count // 4) for count in counts)
    assert all(pair.optimal.values())


def test_each_copy_computes_what_the_problem_does(pair: cordicc.Plan, problem: Path) -> None:
    one = planned(problem)
    samples = draw(pair.problem.workspace, 60, 2)
    together = pair.simulate(samples)
    clocked = pair.simulate(samples, cycle_accurate=True)
    assert all(together[name].tobytes() == clocked[name].tobytes() for name in together)
    alone = [one.simulate({"S": samples[f"S_{copy}"]}) for copy in (1, 2)]
    valid = alone[0]["valid"] * alone[1]["valid"]
    np.testing.assert_array_equal(together["valid"], valid)
    for copy, out in enumerate(alone, 1):
        for name in one.outputs:
            # The operations are the same, in the same format; so the bits are.
            np.testing.assert_array_equal(together[f"{name}_{copy}"][valid == 1], out[name][valid == 1])


def test_the_plan_of_copies_is_read_back(pair: cordicc.Plan) -> None:
    again = parse(dump(pair), "plan.json")
    assert dump(again) == dump(pair)
    assert pair.options.copies == 2
    assert "--copies 2" in pair.report()


def test_one_copy_is_the_plan_itself() -> None:
    plan = planned(EXAMPLES / "wheel_beta.yaml")
    assert replicated(plan, 1) is plan
    assert "copies" not in plan.options.recorded


def test_copies_are_told_apart_by_their_names_alone() -> None:
    plan = planned(EXAMPLES / "planar_2r.yaml")
    three = scheduling_problem(replicated(plan, 3), 4)
    three.check()
    one = scheduling_problem(plan, 4)
    assert len(three.operations) == 3 * len(one.operations)
    assert len({task.id for task in three.operations}) == len(three.operations)
    assert {kind: 3 * count for kind, count in one.counts().items() if not kind.startswith("sign")} == {
        kind: count for kind, count in three.counts().items() if not kind.startswith("sign")
    }


def test_a_graph_is_copied_with_its_constants_once() -> None:
    plan = planned(EXAMPLES / "wheel_beta.yaml")
    graph = plan.problem.program
    two = copied(graph, 2)
    constants = sum(node.op == "const" for node in graph.nodes)
    assert len(two.nodes) == 2 * len(graph.nodes) - constants
    assert sorted(two.outputs) == sorted(f"{name}_{copy}" for name in graph.outputs for copy in (1, 2))
    assert print_graph(parse_graph(print_graph(two), "two")) == print_graph(two)


def test_the_command_writes_and_simulates_copies(tmp_path: Path) -> None:
    run = CliRunner()
    problem = str(EXAMPLES / "wheel_beta.yaml")
    made = run.invoke(main, ["compile", problem, "--copies", "2", "--ii", "2", "-o", str(tmp_path / "two")])
    assert made.exit_code == 0, made.output
    assert "1 CAU: 0 standard, 1 implicit" in made.stdout
    plan = str(tmp_path / "two" / "plan.json")
    out = run.invoke(main, ["simulate", plan, "--random", "50", "--cycle-accurate"])
    assert out.exit_code == 0, out.output
    assert "beta_1" in out.stdout
    assert "beta_2" in out.stdout
