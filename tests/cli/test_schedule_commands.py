import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cordicc.backends.pictures import schedule_chart
from cordicc.base.diagnostics import InvalidInput, Unattainable
from cordicc.ir.sampling import draw
from cordicc.pipeline import Options, plan_file
from cordicc.plan.copies import replicated
from cordicc.plan.file import dump, parse
from cordicc.plan.model import ControlWord, Plan
from cordicc.plan.origin import PlanTarget
from cordicc.plan.verify import verify
from cordicc.schedule.bare import parse_graph, schedule_graph
from cordicc.schedule.place import place
from cordicc.schedule.request import Limits, goals, interval_for, scheduled
from cordicc.schedule.solver.engine import Effort
from cordicc.schedule.solver.scheduling_problem import Schedule, SchedulingProblem, Task, TaskValue
from cordicc.schedule.verify_bare import verify_bare
from cordicc.studies.trade_off import INTERVALS, explore, workers
from cordicc.targets.target import CAU_KINDS
from cordicc.targets.target_file import load_target
from tests.support import plans
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.selection import slow

LIGHT = Effort(schedule=2.0, words=0.5)


def planned(name: str, target: str = "kinematic", **limits: Any) -> Plan:
    options = Options(target, limits=Limits(effort=LIGHT, **limits))
    return plan_file(EXAMPLES / f"{name}.yaml", options).plan


GRAPH: dict[str, Any] = {
    "initiation_interval": 2,
    "minimize": "latency",
    "kinds": {"cau": {"latency": 44, "limit": 2}, "mul": {"latency": 4, "limit": None}},
    "operations": [
        {"id": "a", "kind": "cau"}, {"id": "b", "kind": "cau"}, {"id": "c", "kind": "cau"},
        {"id": "m", "kind": "mul"},
    ],
    "edges": [["a", "m"], ["b", "m"], ["m", "c"], ["a", "c"]],
}  # fmt: skip


@pytest.mark.exhaustive(reason="proves the schedules of five intervals; others are proven in test_goals")
def test_the_wheel_from_pipelined_to_one_cau() -> None:
    caus = planned("wheel_suspension", "imscor24").processors()["total"]
    for interval in range(1, caus + 1):
        plan = planned("wheel_suspension", "imscor24", initiation_interval=interval)
        verify(plan)
        assert all(plan.optimal.values())
        assert plan.processors()["total"] == -(-caus // interval)


@pytest.mark.parametrize("name", [slow("wheel_suspension"), "planar_2r", slow("scara"), slow("delta")])
@pytest.mark.parametrize("interval", [slow(2), 5, slow(16)])
def test_shared_units_give_the_same_bytes_clock_by_clock(name: str, interval: int) -> None:
    plan = plans.planned(EXAMPLES / f"{name}.yaml", ii=interval)
    samples = draw(plan.problem.workspace, 70, 3)
    functional, clocked = plan.simulate(samples), plan.simulate(samples, cycle_accurate=True)
    assert all(functional[key].tobytes() == clocked[key].tobytes() for key in functional)


@pytest.mark.parametrize("interval", [2, slow(4)])
def test_shared_units_in_fixed_point_give_the_same_bytes_clock_by_clock(interval: int) -> None:
    plan = plans.planned(EXAMPLES / "planar_2r.yaml", target="fixed24", ii=interval)
    samples = draw(plan.problem.workspace, 70, 3)
    functional, clocked = plan.simulate(samples), plan.simulate(samples, cycle_accurate=True)
    assert all(functional[key].tobytes() == clocked[key].tobytes() for key in functional)
    assert functional["valid"].any()


def test_a_cluster_needs_its_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InvalidInput, match="needs distributed") as caught:
        workers(None, "tcp://127.0.0.1:1")
    assert caught.value.diagnostics[0].code == "E721"


def test_control_words_are_recorded_read_back_and_verified() -> None:
    plan = plans.planned(EXAMPLES / "wheel_suspension.yaml", ii=4)
    assert parse(dump(plan), "plan.json").units == plan.units
    index, unit = next((k, u) for k, u in enumerate(plan.units) if u.control)
    assert [word.slot for word in unit.control] == sorted(word.slot for word in unit.control)
    word = unit.control[0]

    def changed(**fields: Any) -> Plan:
        units = list(plan.units)
        units[index] = replace(unit, **fields)
        return replace(plan, units=tuple(units))

    other = replace(word, slot=(word.slot + 1) % 4)
    with pytest.raises(AssertionError, match="wrong slot"):
        verify(changed(control=(other, *unit.control[1:])))
    with pytest.raises(AssertionError, match="shared, but without control words"):
        verify(changed(control=(), inputs=()))
    with pytest.raises(AssertionError, match="control words of other operations"):
        verify(changed(control=(*unit.control, ControlWord(0, "o99", ()))))
    with pytest.raises(AssertionError, match="selects nothing"):
        verify(changed(inputs=((),) * len(unit.inputs)))
    with pytest.raises(AssertionError, match="ports without a selection"):
        verify(changed(control=(replace(word, select=()), *unit.control[1:])))


@pytest.mark.exhaustive(reason="schedules twice; examples are compiled twice in another test")
def test_the_same_request_gives_the_same_bytes() -> None:
    assert dump(planned("delta", initiation_interval=8)) == dump(planned("delta", initiation_interval=8))


def shared() -> SchedulingProblem:
    """Two chains of CAUs, the first with a multiplier; interval 2."""
    tasks = (
        Task("a", "standard", 44),
        Task("m", "mul", 4),
        Task("b", "standard", 44),
        Task("c", "standard", 44),
    )
    values = (
        TaskValue("i", None, (("a", "x"), ("c", "x"))),
        TaskValue("a.r", "a", (("m", "x"),)),
        TaskValue("m.r", "m", (("b", "x"),)),
        TaskValue("b.r", "b", (("out", "p"),)),
        TaskValue("c.r", "c", (("out", "q"),)),
    )
    return SchedulingProblem(tasks, values, 2)


KINEMATIC = PlanTarget.of(load_target("kinematic"))


def asked(minimize: str, **limits: Any) -> Schedule:
    problem = shared()
    order = goals(minimize, KINEMATIC, tuple(problem.counts()), {v.name: 32 for v in problem.values})
    return scheduled(problem, order, Limits(minimize, 2, effort=LIGHT, **limits))


def test_goals() -> None:
    # b follows a in 48 cycles, in a's slot, so two units leave c the odd slots: it waits 1 cycle and 47
    # instead of 48 on one side, which takes an entry more.
    found = {name: asked(name) for name in ("processors", "latency", "fifo", "area")}
    assert all(all(each.optimal.values()) for each in found.values())
    figures = {n: (s.figures["processors"], s.latency, s.fifo_words) for n, s in found.items()}
    assert figures == {
        "processors": (2, 92, 25), "latency": (2, 92, 25), "fifo": (3, 92, 24), "area": (2, 92, 25),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("limits", "code", "texts"),
    [
        ({"max_processors": 1}, "E402", ["3 standard operations need 2", "--max-processors 2, or --ii 3"]),
        ({"max_latency": 91}, "E403", ["takes 92 cycles", "--max-latency 92: standard (44) -> mul (4)"]),
    ],
)
def test_what_cannot_be_met_names_what_binds(limits: dict[str, int], code: str, texts: list[str]) -> None:
    with pytest.raises(Unattainable) as caught:
        asked("processors", **limits)
    assert [d.code for d in caught.value.diagnostics] == [code]
    assert all(text in str(caught.value) for text in texts)


def test_limits_that_only_clash_together() -> None:
    # At interval 2 one unit does two operations: two in a chain of 44 cycles would share a slot.
    tasks = (Task("a", "standard", 44), Task("b", "standard", 44))
    values = (TaskValue("a.r", "a", (("b", "x"),)), TaskValue("b.r", "b", (("out", "p"),)))
    problem = SchedulingProblem(tasks, values, 2)
    order = goals("processors", KINEMATIC, ("standard",), {})
    for limits, expected in (({"max_latency": 88}, (2, 88)), ({"max_processors": 1}, (1, 89))):
        solved = scheduled(problem, order, Limits(initiation_interval=2, **limits))
        assert (solved.figures["processors"], solved.latency) == expected
    with pytest.raises(Unattainable, match=r"E407.*88 cycles takes 2 CAUs .2 standard") as caught:
        scheduled(problem, order, Limits(initiation_interval=2, max_processors=1, max_latency=88))
    hint = "nearest: --max-processors 2 at this latency, or --max-latency 89 with --max-processors 1"
    assert caught.value.diagnostics[0].hint == hint


def test_rate() -> None:
    target = load_target("kinematic")
    assert [interval_for(target, rate) for rate in (1e7, 9.9e6, 2.5e6, 1e6, 3e6)] == [1, 1, 4, 10, 3]
    for rate in (1.01e7, float("inf"), float("nan")):
        with pytest.raises(Unattainable, match="E406"):
            interval_for(target, rate)


@pytest.mark.exhaustive(reason="copies have tests of their own in tests/plan")
def test_copies_share_the_units() -> None:
    base = plans.planned(EXAMPLES / "quadruped_leg.yaml")
    four = place(replicated(base, 4), Limits(initiation_interval=16, effort=LIGHT))
    verify(four)
    assert len(four.operations) == 4 * len(base.operations)
    kinds = [sum(o.kind == kind for o in four.operations) for kind in CAU_KINDS]
    assert four.processors()["total"] == sum(-(-count // 16) for count in kinds)
    assert place(replicated(base, 1), Limits()) == base


def test_effort_scales_all_work_and_is_recorded(tmp_path: Path) -> None:
    assert Effort(4.0, 2.0, 1.0, 60.0).times(0.5) == Effort(2.0, 1.0, 0.5, 60.0)
    file = str(EXAMPLES / "planar_2r.yaml")
    assert run("compile", file, "-q", "--ii", "2", "--effort", "0.5", "-o", str(tmp_path)).exit_code == 0
    plan = parse((tmp_path / "plan.json").read_text(encoding="utf-8"), "plan.json")
    assert plan.options.effort == 0.5
    assert "--effort 0.5" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert run("compile", file, "--effort", "0").exit_code == 2


@pytest.mark.exhaustive(reason="schedules twice; pictures of shared units are drawn in tests/backends")
def test_the_chart_of_slots_does_not_grow_with_the_latency() -> None:
    plan = plans.planned(EXAMPLES / "wheel_suspension.yaml", ii=4)
    picture = schedule_chart.render(plan)
    timed = {unit.id for unit in plan.units if unit.latency}
    cells = sum(operation.unit in timed for operation in plan.operations)
    assert picture.count('data-id="slot.') == cells
    assert "slot." not in schedule_chart.render(plans.planned(EXAMPLES / "wheel_suspension.yaml"))


def test_explore_finds_a_front() -> None:
    calls: list[tuple[int, int]] = []
    path = EXAMPLES / "wheel_beta.yaml"
    front = explore(path, "imscor24", "auto", 1, workers(1, None), lambda d, n: calls.append((d, n)))
    assert calls[-1][0] == calls[-1][1] >= front.tried
    assert all(all(point.optimal.values()) for point in front.points)
    figures = [point.figures() for point in front.points]
    assert {point.initiation_interval for point in front.points} <= set(INTERVALS)
    for a in figures:
        assert not any(b != a and all(x <= y for x, y in zip(b, a, strict=True)) for b in figures)


def test_explore_tells_what_is_wrong_with_a_file(tmp_path: Path) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text("inputs: {x: [0, 1]}\nequations: [y = x + z]\n")
    with pytest.raises(InvalidInput, match="unknown name 'z'"):
        explore(file, "kinematic", "auto", 1, workers(1, None), lambda done, count: None)


def test_a_latency_found_on_the_way_to_fewer_words_is_kept() -> None:
    asked = {
        **GRAPH,
        "operations": [{"id": f"{kind}{k}", "kind": kind} for k in range(4) for kind in ("cau", "mul")],
        "edges": [[f"cau{k}", f"mul{k}"] for k in range(4)],
    }
    answer = schedule_graph(parse_graph(json.dumps(asked), "g"), Effort(schedule=0.0, words=0.0))
    verify_bare(asked, answer)
    assert (answer["latency"], answer["fifo_words"]) == (49, 0)


def test_a_bare_graph(tmp_path: Path) -> None:
    file, out = tmp_path / "graph.json", tmp_path / "out.json"
    file.write_text(json.dumps(GRAPH))
    result = run("schedule", str(file), "-o", str(out))
    assert (result.exit_code, result.stdout) == (
        0, "latency 93 (proven optimal)\nfifo words 5 (proven optimal)\n",
    )  # fmt: skip
    answer = json.loads(out.read_text())
    verify_bare(GRAPH, answer)
    assert run("schedule", str(file)).stdout == out.read_text()


@pytest.mark.parametrize("kinds", [("k", "k1"), ("k1", "k"), ("k", "k1", "k11"), ("1", "11"), ("k", "k0")])
@pytest.mark.parametrize("interval", [1, 2])
def test_units_of_kinds_with_digits_have_names_of_their_own(kinds: tuple[str, ...], interval: int) -> None:
    asked = {
        "initiation_interval": interval,
        "minimize": "processors",
        "kinds": {kind: {"latency": 1} for kind in kinds},
        "operations": [{"id": f"{kind}.{n}", "kind": kind} for kind in kinds for n in range(23)],
        "edges": [],
    }
    answer = schedule_graph(parse_graph(json.dumps(asked), "g"), LIGHT)
    verify_bare(asked, answer)
    units = set(answer["unit"].values())
    assert len(units) == answer["bounds"]["processors"] == len(kinds) * -(-23 // interval)
    assert {f"{kinds[0]}{n}" for n in range(-(-23 // interval))} <= units


def test_kinds_that_share_a_unit_are_found() -> None:
    asked = {
        "initiation_interval": 2,
        "kinds": {"k": {"latency": 1}, "k1": {"latency": 1}},
        "operations": [{"id": "a", "kind": "k"}, {"id": "b", "kind": "k1"}],
        "edges": [],
    }
    answer = {
        "start": {"a": 0, "b": 0}, "unit": {"a": "k10", "b": "k10"}, "latency": 1, "fifo_words": 0,
        "optimal": {}, "bounds": {},
    }  # fmt: skip
    with pytest.raises(AssertionError, match="'k10' has several operations in a slot"):
        verify_bare(asked, answer)
    with pytest.raises(AssertionError, match="'k10' is of several kinds"):
        verify_bare(asked, {**answer, "start": {"a": 0, "b": 1}, "latency": 2})


def test_bare_goals() -> None:
    unlimited = {**GRAPH, "kinds": {"cau": {"latency": 44}, "mul": {"latency": 4}}}
    for minimize in ("latency", "fifo", "processors"):
        asked = {**unlimited, "minimize": minimize}
        answer = schedule_graph(parse_graph(json.dumps(asked), "g"), LIGHT)
        verify_bare(asked, answer)
        assert all(answer["optimal"].values())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": {"a": 0, "b": 0, "m": 43, "c": 48}}, "'m' starts 1 cycles before 'a' is done"),
        ({"unit": {"a": "cau0", "b": "cau0", "m": "mul0", "c": "cau1"}}, "several operations in a slot"),
        ({"unit": {"a": "cau0", "b": "mul1", "m": "mul0", "c": "cau1"}}, "'b' is on unit 'mul1'"),
        ({"unit": {"a": "cau0", "b": "cau2", "m": "mul0", "c": "cau1"}}, "3 units of kind 'cau', limit 2"),
        ({"latency": 91}, "latency 91, expected 93"),
        ({"fifo_words": 3}, "FIFO words 3, expected 6"),
        ({"bounds": {"latency": 94, "fifo_words": 4}}, "93 is below its bound 94"),
        ({"optimal": {"latency": True, "fifo_words": False}}, "latency: called optimal with bound 92"),
        ({"start": {"a": 0}}, "the operations differ"),
    ],
)
def test_a_wrong_answer_is_found(change: dict[str, Any], message: str) -> None:
    right = {
        "start": {"a": 0, "b": 0, "m": 44, "c": 49},
        "unit": {"a": "cau0", "b": "cau1", "m": "mul0", "c": "cau0"},
        "latency": 93, "fifo_words": 6, "optimal": {"latency": False, "fifo_words": False},
        "bounds": {"latency": 92, "fifo_words": 4},
    }  # fmt: skip
    verify_bare(GRAPH, right)
    with pytest.raises(AssertionError, match=message):
        verify_bare(GRAPH, {**right, **change})


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("{", "E801", "not a graph"),
        ("[" * 100_000, "E801", "not a graph"),
        ("[]", "E801", "must be an object"),
        ('{"kinds": {}, "kinds": {}}', "E801", "the key 'kinds' occurs twice"),
        ('{"initiation_interval": NaN}', "E801", "NaN is not a number"),
        ('{"initiation_interval": 1' + "0" * 5000 + "}", "E801", "too large"),
        ({"extra": 1}, "E801", 'unknown key "extra"'),
        ({"initiation_interval": 0}, "E801", "not an integer from 1 to 1000000"),
        ({"initiation_interval": True}, "E801", "initiation_interval is true"),
        ({"minimize": "area"}, "E801", "not one of latency, fifo, processors"),
        ({"minimize": []}, "E801", "minimize is"),
        ({"kinds": {"cau": {"latency": -1}}}, "E801", "kinds.cau.latency is -1"),
        ({"kinds": {"cau": {"limit": 1}}}, "E801", "must be an object with 'latency'"),
        ({"kinds": {"cau": {"latency": 1.5}}}, "E801", "kinds.cau.latency is 1.5"),
        ({"operations": [{"id": "a"}]}, "E801", r"operations\[0\] must be an object"),
        ({"operations": [{"id": 7, "kind": "cau"}]}, "E801", r"operations\[0\].id must be printable text"),
        ({"operations": [{"id": "a\n", "kind": "cau"}]}, "E801", r"operations\[0\].id must be printable"),
        ({"operations": [{"id": "a", "kind": "x"}]}, "E802", 'unknown kind "x"'),
        ({"operations": [{"id": "a", "kind": []}]}, "E802", "unknown kind"),
        ({"operations": [{"id": "a", "kind": "cau"}] * 2}, "E802", "the id 'a' occurs twice"),
        ({"edges": [["a"]]}, "E801", r"edges\[0\] must be a list of two ids"),
        ({"edges": [["a", "z"]]}, "E802", 'unknown operation "z"'),
        ({"edges": [["a", "b"], ["b", "a"]]}, "E802", "depend on one another"),
        ({"edges": [["a", "a"]]}, "E802", "depend on one another"),
    ],
)
def test_hostile_graphs(text: str | dict[str, Any], code: str, message: str) -> None:
    given = text if isinstance(text, str) else json.dumps({**GRAPH, **text})
    with pytest.raises(InvalidInput, match=message) as caught:
        parse_graph(given, "graph.json")
    assert caught.value.diagnostics[0].code == code


def test_an_id_may_be_out() -> None:
    asked = {**GRAPH, "operations": [{"id": "out", "kind": "mul"}], "edges": []}
    assert schedule_graph(parse_graph(json.dumps(asked), "g"), LIGHT)["start"] == {"out": 0}


def test_too_few_units_of_a_kind(tmp_path: Path) -> None:
    file = tmp_path / "graph.json"
    file.write_text(json.dumps({**GRAPH, "kinds": {**GRAPH["kinds"], "cau": {"latency": 44, "limit": 1}}}))
    result = run("schedule", str(file))
    assert result.exit_code == 1
    assert "3 operations of kind 'cau' need 2 units at interval 2, more than the limit 1" in result.stderr
    assert "a limit of 2, or an initiation interval of 3" in result.stderr
