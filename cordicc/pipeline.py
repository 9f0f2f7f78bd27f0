"""The compiler, stage by stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from cordicc.arith.fixed_system import FixedSystem
from cordicc.backends import datapath, graph_view, report, schedule_chart, script
from cordicc.checks import check_domain, check_meaning, input_intervals
from cordicc.diagnostics import Diagnostic, InvalidInput
from cordicc.emulate import functional as functional_run
from cordicc.emulate import sampling
from cordicc.frontend.load import LoadedProblem, load_problem
from cordicc.guard_bits import fewest_guard_bits
from cordicc.ir.graph import Graph, Value
from cordicc.ir.ops import Level
from cordicc.ir.problem import Problem
from cordicc.ir.text import parse_graph
from cordicc.ir.verify import verify as verify_graph
from cordicc.observation import DEFAULT_SEED, machine_of, observe
from cordicc.plan import Plan
from cordicc.plan_check import check_operations, check_problem, check_sizes
from cordicc.plan_json import dump
from cordicc.record import problem_data
from cordicc.rewrite.base import Context
from cordicc.rewrite.passes import default_passes
from cordicc.schedule.assemble import Limits, assemble
from cordicc.schedule.verify import verify as verify_plan
from cordicc.targets.model import DEFAULT_TARGET, Target, load_target
from cordicc.word_lengths import formats, magnitudes

ARTEFACTS = ("plan.json", "report.html", "datapath.svg", "schedule.svg", "simulate.py")
"""The files of an output folder."""

Watch = Callable[[str, Graph], None]


@dataclass(frozen=True, slots=True)
class Options:
    """What the user asks for besides the equations."""

    target: str = DEFAULT_TARGET
    units: str = "auto"
    limits: Limits = field(default_factory=Limits)


@dataclass(frozen=True, slots=True)
class Compiled:
    """A plan and the warnings that came up on the way."""

    plan: Plan
    warnings: tuple[Diagnostic, ...]


def read_problem(path: Path) -> LoadedProblem:
    """Read a problem and look for inputs outside the domain; the first stage, and all of `check`."""
    loaded = load_problem(path)
    return replace(loaded, warnings=(*loaded.warnings, *check_domain(loaded.problem, loaded.source)))


def compile_file(path: Path, options: Options, watch: Watch | None = None) -> Compiled:
    """Compile a problem file.

    Args:
        path: the problem file.
        options: target, units, limits.
        watch: called with the name and the graph after each pass, for `--print-after`.

    Raises:
        InvalidInput: the file, the target or an option is invalid.
        Unattainable: no plan within the limits, or no number format that holds a value.
    """
    planned = plan_file(path, options, watch)
    # The finished plan is run: its accuracy figures are those of the bits it would produce.
    plan, more = observe(planned.plan)
    return Compiled(plan, (*planned.warnings, *more))


def plan_file(path: Path, options: Options, watch: Watch | None = None) -> Compiled:
    """Compile a problem file without running the plan: `compile_file` without accuracy figures."""
    # The file first: without a problem there is nothing to plan, and its mistakes are told together.
    loaded = read_problem(path)
    target = load_target(options.target)
    # Rewriting is free of the target but for one question: are there implicit CAUs?
    implicit = _implicit_allowed(options.units, target)
    graph = rewrite(loaded.problem, implicit=implicit, goal=options.limits.minimize, watch=watch)
    if isinstance(target.machine().system, FixedSystem):
        return _fixed_point_plan(path, loaded, graph, target, options)
    record = problem_data(loaded.problem, loaded.warnings)
    return Compiled(_scheduled(path, graph, target, options, record, {}), tuple(loaded.warnings))


def _fixed_point_plan(
    path: Path, loaded: LoadedProblem, graph: Graph, target: Target, options: Options
) -> Compiled:
    """Choose a binary point for every value, and as many guard bits as the accuracy needs."""
    held = magnitudes(loaded.problem, loaded.source, graph)
    warnings = (*loaded.warnings, *held.warnings)
    record = problem_data(loaded.problem, warnings)

    def plan_for(target: Target) -> Plan:
        system = target.machine().system
        assert isinstance(system, FixedSystem)
        return _scheduled(path, graph, target, options, record, formats(held, graph, system))

    if not target.guard_is_open:
        return Compiled(plan_for(target), warnings)
    plan = fewest_guard_bits(record, lambda guard: plan_for(load_target(options.target, guard)))
    return Compiled(plan, warnings)


def _scheduled(
    path: Path,
    graph: Graph,
    target: Target,
    options: Options,
    record: Mapping[str, Any],
    formats: Mapping[Value | str, dict[str, int]],
) -> Plan:
    # Scheduling sees unit operations with their latencies only.
    plan = assemble(
        graph, target, options.limits, problem=record, options=_recorded(path, options), formats=formats
    )
    verify_plan(plan)
    return plan


def rewrite(problem: Problem, *, implicit: bool, goal: str, watch: Watch | None = None) -> Graph:
    """Return the graph of unit operations that computes a problem's outputs."""
    context = Context(input_intervals(problem), goal)
    graph = problem.graph
    verify_graph(graph)
    if watch is not None:
        watch("frontend", graph)
    for step in default_passes(implicit=implicit):
        graph = step.apply(graph, context)
        verify_graph(graph)
        if watch is not None:
            watch(step.name, graph)
    verify_graph(graph, frozenset({Level.LEAF, Level.ARITHMETIC, Level.UNIT}))
    check_meaning(problem, graph)
    return graph


def pass_names() -> tuple[str, ...]:
    """Return the names that `--print-after` knows."""
    return ("frontend", *dict.fromkeys(step.name for step in default_passes(implicit=False)))


def artefacts(plan: Plan) -> dict[str, str]:
    """Return the files of an output folder, by name."""
    renderers = (dump, report.render, datapath.render, schedule_chart.render, script.render)
    return {name: render(plan) for name, render in zip(ARTEFACTS, renderers, strict=True)}


def picture(plan: Plan, view: str) -> str:
    """Return the SVG of a view: datapath, schedule or graph."""
    views = {"datapath": datapath.render, "schedule": schedule_chart.render, "graph": graph_view.render}
    return views[view](plan)


def _implicit_allowed(units: str, target: Target) -> bool:
    if units == "implicit" and not target.has_implicit:
        message = f"target '{target.name}' has no implicit CAUs"
        raise InvalidInput([Diagnostic("E404", message, hint="use --units auto, or another --target")])
    return target.has_implicit and units != "standard"


def _recorded(path: Path, options: Options) -> dict[str, Any]:
    limits = options.limits
    return {
        "file": path.name,
        "target": options.target if options.target.isidentifier() else Path(options.target).name,
        "units": options.units,
        "minimize": limits.minimize,
        "ii": limits.initiation_interval,
        "max_processors": limits.max_processors,
        "max_latency": limits.max_latency,
    }


def check_plan(plan: Plan, name: str) -> Plan:
    """Return a plan that was read back, with its schedule, wiring and arithmetic verified.

    Raises:
        InvalidInput: the plan contradicts itself.
    """
    try:
        check_sizes(plan)
        check_problem(plan)
        check_operations(plan)
        verify_plan(plan)
        program = parse_graph(plan.problem["program"], name)
        verify_graph(program)
        inputs = {str(node.params[0]) for node in program.nodes if node.op == "input"}
        assert inputs == {item["name"] for item in plan.problem["inputs"]}, "the inputs of the program differ"
        assert set(program.outputs) == set(plan.outputs), "the outputs of the program differ"
        functional_run.run(plan, machine_of(plan), sampling.draw(plan.problem, 1, DEFAULT_SEED))
    except (AssertionError, ArithmeticError, ValueError, LookupError, TypeError) as error:
        reason = (str(error).splitlines() or ["malformed"])[0][:500]
        message = f"the plan contradicts itself: {reason}"
        raise InvalidInput([Diagnostic("E603", message, hint="compile the problem again")]) from None
    return plan
