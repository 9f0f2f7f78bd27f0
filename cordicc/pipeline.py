"""The compiler, stage by stage.

The proof of bounds, which not every run needs, is imported where it is used, for a quick start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Unattainable
from cordicc.emulate.observation import observe, with_warnings
from cordicc.emulate.vanishing import with_ends
from cordicc.frontend.domain import check_domain
from cordicc.frontend.load import LoadedProblem, load_problem
from cordicc.ir.graph import Graph
from cordicc.ir.ops import Level
from cordicc.ir.problem import Problem, input_intervals
from cordicc.ir.well_formed import verify as verify_graph
from cordicc.plan.copies import replicated
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanOptions
from cordicc.plan.verify import verify as verify_plan
from cordicc.precision.allowed_error import TooInaccurate, allowed_errors, exceptions
from cordicc.precision.choose import plan_with_formats
from cordicc.rewrite.cheapest import Choice, cheapest
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import default_passes, through_passes
from cordicc.rewrite.same_meaning import check_meaning
from cordicc.rewrite.search.costs import Costs
from cordicc.schedule.place import figures, place
from cordicc.schedule.request import Limits, OutOfLimits
from cordicc.targets.device import DEVICES
from cordicc.targets.target import DEFAULT_TARGET, Target, function_name
from cordicc.targets.target_file import AS_WRITTEN, Asked, load_target

if TYPE_CHECKING:
    from cordicc.certify.certificate import Bound

MAX_OPERATIONS, MAX_INPUTS = 5_000, 1_000
"""Operations and inputs of which a plan is made at the most; beyond, it would take minutes."""

Watch = Callable[[str, Graph], None]
Enter = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Options:
    """What the user asks for besides the equations."""

    target: str = DEFAULT_TARGET
    units: str = "auto"
    limits: Limits = field(default_factory=Limits)
    certify: bool | None = None
    """Derive proven error bounds; by default on fixed-point targets. A `max_error` asks for them anyway."""
    copies: int = 1
    """Instances of the problem that share the units, see `cordicc.plan.copies`."""
    effort: float = 1.0
    """The work of searches, as a multiple of the usual; more proves more, and may find less hardware."""
    asked: Asked = AS_WRITTEN
    """Width of words and clock instead of the target's own."""

    def loaded(self) -> Target:
        """Return the target with what is asked for; raises InvalidInput."""
        return load_target(self.target, asked=self.asked)


@dataclass(frozen=True, slots=True)
class Compiled:
    """A plan and the warnings that came up on the way."""

    plan: Plan
    warnings: tuple[Diagnostic, ...]


def read_problem(path: Path) -> LoadedProblem:
    """Read a problem and look for inputs outside the domain; the first stage, and all of `check`."""
    loaded = load_problem(path)
    return replace(loaded, warnings=(*loaded.warnings, *check_domain(loaded.problem, loaded.source)))


def _nobody(name: str) -> None:
    """Take the name of a stage where nobody wants to know it."""


def compile_file(
    path: Path, options: Options, watch: Watch | None = None, enter: Enter = _nobody
) -> Compiled:
    """Compile a problem file.

    Args:
        path: the problem file.
        options: target, units, limits.
        watch: called with the name and the graph after each pass, for `--print-after`.
        enter: called with what is about to be done, to show progress.

    Raises:
        InvalidInput: the file, the target or an option is invalid.
        Unattainable: no plan within the limits, or no number format that holds a value.
    """
    return judged(plan_file(path, options, watch, enter), options.certify, enter)


def judged(planned: Compiled, certify: bool | None = None, enter: Enter = _nobody) -> Compiled:
    """Return what `plan_file` made with its accuracy figures, with error bounds where `certify` asks.

    The area is estimated too, where the target has a device.
    """
    enter("simulating the plan")
    # The finished plan is run: its accuracy figures are those of the bits it would produce.
    with _telling(planned.warnings):
        plan, more = observe(planned.plan)
    allowed = allowed_errors(plan.problem)
    fixed_point = isinstance(plan.arithmetic.system, FixedSystem)
    if allowed or (fixed_point if certify is None else certify):
        from cordicc.certify.plans import with_bounds

        enter("proving error bounds")
        plan = with_bounds(plan, _bounds_of(plan, allowed))
        open_ones = exceptions(plan)
        plan, more = with_warnings(plan, open_ones), [*more, *open_ones]
    enter("looking for where accuracy ends")
    # Samples seldom come near enough to the zeros of denominators to show it.
    plan, ends = with_ends(plan)
    plan, more = with_warnings(plan, ends), [*more, *ends]
    return _with_estimate(Compiled(plan, (*planned.warnings, *more)), enter)


def _with_estimate(made: Compiled, enter: Enter) -> Compiled:
    """Return a plan with the area that its target's device is expected to need, where it has one."""
    if made.plan.target.device is None:
        return made
    from cordicc.backends.synthesis.estimate import estimated_area
    from cordicc.backends.synthesis.room import too_large

    enter("estimating the area")
    area = estimated_area(made.plan)
    if area is None:
        return made
    more = too_large(area, DEVICES[made.plan.target.device], "about ")
    plan, more = with_warnings(replace(made.plan, estimate=area), more), more
    return Compiled(plan, (*made.warnings, *more))


def plan_file(path: Path, options: Options, watch: Watch | None = None, enter: Enter = _nobody) -> Compiled:
    """Compile a problem file without running the plan: `compile_file` without accuracy figures."""
    # The file first: without a problem there is nothing to plan, and its mistakes are told together.
    enter("reading the problem")
    loaded = read_problem(path)
    with _telling(loaded.warnings):
        return _plan_of(path, loaded, options, watch, enter)


@contextmanager
def _telling(warnings: tuple[Diagnostic, ...]) -> Iterator[None]:
    """Let a refusal tell what was found before: it may be why, and without a plan it would not be told."""
    try:
        yield
    except Unattainable as error:
        error.warnings = warnings
        raise


def _plan_of(
    path: Path, loaded: LoadedProblem, options: Options, watch: Watch | None, enter: Enter
) -> Compiled:
    """Return the plan of a problem that was read, and all warnings."""
    _check_size(loaded)
    target = options.loaded()
    limits = replace(options.limits, effort=options.limits.effort.times(options.effort))
    request = _Request(path, loaded, target, replace(options, limits=limits), watch, enter)
    refused: list[Unattainable] = []
    for goal in _goals(limits):
        if plans := _plans(request, goal, refused):
            break
    else:
        raise _nearest(refused)
    plan, warnings = min(plans, key=lambda made: figures(made[0], limits.minimize))
    verify_plan(plan)
    return Compiled(plan, warnings)


def _goals(limits: Limits) -> tuple[str, ...]:
    """Return the goals for which operations are chosen, one after the other until the limits are met."""
    wanted = [limits.minimize]
    wanted += ["processors"] if limits.max_processors is not None else []
    wanted += ["latency"] if limits.max_latency is not None else []
    return tuple(dict.fromkeys(wanted))


def _nearest(refused: Sequence[Unattainable]) -> Unattainable:
    """Return of several reasons the one that is nearest to a plan."""
    missed = [error for error in refused if isinstance(error, OutOfLimits)]
    if missed:
        return min(missed, key=lambda error: error.least)
    inaccurate = [error for error in refused if isinstance(error, TooInaccurate)]
    return min(inaccurate, key=lambda error: error.excess) if inaccurate else refused[0]


@dataclass(frozen=True, slots=True)
class _Request:
    """What is compiled, for what, and who watches."""

    path: Path
    loaded: LoadedProblem
    target: Target
    options: Options
    watch: Watch | None
    enter: Enter


def _plans(
    request: _Request, goal: str, refused: list[Unattainable]
) -> list[tuple[Plan, tuple[Diagnostic, ...]]]:
    """Return plans with operations chosen for a goal; why others cannot be is added to `refused`."""
    options, plans = request.options, []
    # Rewriting is free of the target but for costs and one question: are there implicit CAUs?
    choice: Choice | None = None
    for implicit in _implicit_choices(options, request.target):
        if choice is not None and all(node.op != "implicit" for node in choice.graph.nodes):
            # Where implicit CAUs are allowed and none is worth it, forbidding them changes nothing.
            break
        request.enter("choosing operations")
        choice = rewrite(
            request.loaded.problem,
            request.target,
            implicit=implicit,
            preferred=options.units == "implicit",
            goal=goal,
            effort=options.effort,
            watch=request.watch,
        )
        try:
            plans.append(_planned(request, choice))
        except TooInaccurate as error:
            # An error cannot be met only if it cannot be met by lengths that take no squares either.
            refused.append(error)
            accurate = most_accurate(request.loaded.problem, request.target, implicit=implicit, goal=goal)
            if accurate.graph != choice.graph:
                try:
                    plans.append(_planned(request, accurate))
                except (TooInaccurate, OutOfLimits) as other:
                    refused.append(other)
        except OutOfLimits as error:
            refused.append(error)
    return plans


def _planned(request: _Request, choice: Choice) -> tuple[Plan, tuple[Diagnostic, ...]]:
    """Return the plan with chosen operations; raises TooInaccurate or OutOfLimits."""
    request.enter("choosing formats and a schedule")
    # Scheduling sees unit operations with their latencies only.
    options = request.options
    target_with = partial(
        load_target,
        options.target,
        used=_functions(choice.graph),
        alone=options.limits.initiation_interval == 1,
        asked=options.asked,
    )
    unplaced, warnings = plan_with_formats(
        request.loaded,
        choice,
        target_with(),
        target_with,
        _recorded(request.path, options),
        _bounds_of,
        _with_borders,
    )
    return place(replicated(unplaced, options.copies), options.limits), warnings


def _functions(graph: Graph) -> frozenset[str]:
    """Return what the operations of a graph ask of units."""
    found = set()
    for index in graph.live():
        node = graph.nodes[index]
        m = dict(zip(node.definition.params, node.params, strict=True)).get("m")
        found.add(function_name(node.op, None if m is None else int(m)))
    return frozenset(found)


def _bounds_of(plan: Plan, allowed: Mapping[str, float]) -> dict[str, Bound]:
    """Return the proven bounds of a plan, given by output the errors that its problem allows."""
    from cordicc.certify.plans import bounds_of

    return bounds_of(plan, allowed)


def _with_borders(plan: Plan) -> Plan:
    """Return a plan whose operations tell how far rounding may carry a sample across their border."""
    from cordicc.certify.borders import with_borders

    return with_borders(plan)


def _check_size(loaded: LoadedProblem) -> None:
    """Raise Unattainable if a problem is too large for a plan."""
    nodes = loaded.problem.graph.nodes
    counts = {
        "inputs": (sum(node.op == "input" for node in nodes), MAX_INPUTS),
        "operations": (len(nodes), MAX_OPERATIONS),
    }
    for noun, (count, most) in counts.items():
        if count <= most:
            continue
        message = f"the problem has {count} {noun}, more than the {most} of which a plan is made"
        hint = "divide it into several files"
        raise Unattainable([Diagnostic("E415", message, None, hint, source=loaded.source)])


def rewrite(
    problem: Problem,
    target: Target,
    *,
    implicit: bool,
    goal: str,
    preferred: bool = False,
    effort: float = 1.0,
    watch: Watch | None = None,
) -> Choice:
    """Return the graph of unit operations that computes a problem's outputs, cheapest on a target."""
    costs = Costs.of(target, implicit=implicit, preferred=preferred)
    context = PassContext(input_intervals(problem), goal, costs.floating, effort)
    graph = problem.graph
    verify_graph(graph)
    if watch is not None:
        watch("frontend", graph)
    for step in default_passes(implicit=implicit):
        graph = step.apply(graph, context)
        verify_graph(graph)
        if watch is not None:
            watch(step.name, graph)
    # One realisation is certain now; around it the search looks for the cheapest.
    choice = cheapest(problem, graph, context, costs)
    if watch is not None:
        watch("search", choice.graph)
    verify_graph(choice.graph, frozenset({Level.LEAF, Level.ARITHMETIC, Level.UNIT}))
    check_meaning(problem, choice.graph)
    return choice


def most_accurate(problem: Problem, target: Target, *, implicit: bool, goal: str) -> Choice:
    """Return the realisation of the passes in which small values lose the fewest digits."""
    floating = Costs.of(target, implicit=implicit).floating
    context = PassContext(input_intervals(problem), goal, floating, careful=True)
    graph = through_passes(problem.graph, context, implicit=implicit)
    return Choice(graph, left_out=("all alternatives: an allowed error cannot be met by the cheapest",))


def pass_names() -> tuple[str, ...]:
    """Return the names that `--print-after` knows."""
    return ("frontend", *dict.fromkeys(step.name for step in default_passes(implicit=False)), "search")


def _implicit_choices(options: Options, target: Target) -> tuple[bool, ...]:
    """Return whether implicit CAUs may be used; both if plans with and without them must be compared.

    Where operations share units over time, one kind of CAU may do with fewer than two.
    """
    if options.units == "implicit" and not target.has_implicit:
        message = f"target '{target.name}' has no implicit CAUs"
        raise InvalidInput([Diagnostic("E404", message, hint="use --units auto, or another --target")])
    if not target.has_implicit or options.units == "standard":
        return (False,)
    shared = options.units == "auto" and options.limits.initiation_interval > 1
    return (True, False) if shared else (True,)


def _recorded(path: Path, options: Options) -> PlanOptions:
    limits = options.limits
    return PlanOptions(
        file=path.name,
        target=options.target if options.target.isidentifier() else Path(options.target).name,
        units=options.units,
        minimize=limits.minimize,
        ii=limits.initiation_interval,
        max_processors=limits.max_processors,
        max_latency=limits.max_latency,
        certify=options.certify,
        effort=None if options.effort == 1 else options.effort,
        width=options.asked.width_bits,
        clock=options.asked.clock_hz,
    )
