"""From what the user asks to goals, and from what cannot be met to the nearest that can."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import lcm

from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.plan.origin import PlanTarget
from cordicc.schedule.solver.dependences import network
from cordicc.schedule.solver.engine import Effort, solve
from cordicc.schedule.solver.goals import FIFO_WORDS, LATENCY, Goal, units_used
from cordicc.schedule.solver.scheduling_problem import OUT, InfeasibleError, Schedule, SchedulingProblem
from cordicc.targets.target import CAU_KINDS, Target

PROCESSORS = Goal("processors", units=dict.fromkeys(CAU_KINDS, 1))
MULTIPLIERS = Goal("mul", units={"mul": 1})
_FINEST_AREA = 10**6


@dataclass(frozen=True, slots=True)
class Limits:
    """What the user asks of the plan besides the equations."""

    minimize: str = "processors"
    initiation_interval: int = 1
    max_processors: int | None = None
    max_latency: int | None = None
    effort: Effort = field(default_factory=Effort)


class OutOfLimits(Unattainable):
    """No schedule within the limits; `least` is what the limit that binds would have to be, if one does."""

    def __init__(self, code: str, message: str, hint: str, least: int = 0) -> None:
        super().__init__([Diagnostic(code, message, hint=hint)])
        self.least = least


def interval_for(target: Target, rate_hz: float) -> int:
    """Return the longest interval in cycles at which so many samples a second enter.

    Raises Unattainable (E406) for a rate above the target's clock.
    """
    if not rate_hz <= target.clock_hz:
        message = f"--rate {rate_hz:g} is above the clock of target '{target.name}'"
        hint = f"the most that can be met is --rate {target.clock_hz:g}"
        raise Unattainable([Diagnostic("E406", message, hint=hint)])
    # An interval is a ratio of two rates in the file's decimals, so it is compared exactly.
    return int(Fraction(str(target.clock_hz)) / Fraction(str(rate_hz)))


def goals(
    minimize: str, target: PlanTarget, kinds: Sequence[str], widths: Mapping[str, int]
) -> tuple[Goal, ...]:
    """Return the goals in order; `widths` are the bits of each value."""
    usual = (PROCESSORS, MULTIPLIERS, LATENCY, FIFO_WORDS)
    if minimize == "processors":
        return usual
    if minimize == "area":
        return (_area(target, kinds, widths), *usual)
    first = {"latency": LATENCY, "fifo": FIFO_WORDS}[minimize]
    return (first, *(goal for goal in usual if goal is not first))


def _area(target: PlanTarget, kinds: Sequence[str], widths: Mapping[str, int]) -> Goal:
    """Return the area in integers: a common multiple of the target's figures."""
    areas = {kind: Fraction(str(target.units[kind.split(" ")[0]].area)) for kind in kinds}
    bit = Fraction(str(target.fifo_area_per_bit))
    scale = min(lcm(bit.denominator, *(area.denominator for area in areas.values())), _FINEST_AREA)
    units = {kind: round(area * scale) for kind, area in areas.items()}
    return Goal("area", units, 0, round(bit * scale), dict(widths))


def scheduled(problem: SchedulingProblem, order: Sequence[Goal], limits: Limits) -> Schedule:
    """Return the schedule that is best in the goals within the limits.

    Raises:
        OutOfLimits: no plan within the limits (E402, E403, E406, E407), with what binds and the nearest
            values that can be met.
    """
    max_processors, max_latency, effort = limits.max_processors, limits.max_latency, limits.effort
    _check_interval(problem)
    _check_processors(problem, max_processors)
    _check_path(problem, max_latency)
    most = None if max_processors is None else (PROCESSORS, max_processors)
    try:
        return solve(problem, order, max_latency=max_latency, most=most, effort=effort)
    except InfeasibleError:
        assert most is not None
        assert max_latency is not None
        raise _both(problem, most, max_latency, effort) from None


def _check_interval(problem: SchedulingProblem) -> None:
    longest = max(problem.operations, key=lambda task: task.busy, default=None)
    if longest is None or longest.busy <= problem.interval:
        return
    message = (
        f"a sample every {problem.interval} cycle{'s' if problem.interval > 1 else ''} is more than a unit "
        f"of kind {longest.kind.split(' ')[0]} can take, which is busy for {longest.busy}"
    )
    hint = f"the least that can be met is --ii {longest.busy}"
    raise OutOfLimits("E406", message, hint, longest.busy)


def _check_processors(problem: SchedulingProblem, limit: int | None) -> None:
    counts = {kind: count for kind, count in problem.counts().items() if kind in CAU_KINDS}
    least = sum(problem.fewest(kind) for kind in counts)
    if limit is None or least <= limit:
        return
    needs = ", ".join(
        f"{count} {kind} operation{'s need' if count != 1 else ' needs'} {problem.fewest(kind)}"
        for kind, count in counts.items()
    )
    message = (
        f"at interval {problem.interval} the plan needs {least} CAUs ({needs}), "
        f"more than --max-processors {limit}"
    )
    hint = f"the least that can be met is --max-processors {least}"
    if limit >= len(counts):
        interval = problem.interval
        while sum(replace(problem, interval=interval).fewest(kind) for kind in counts) > limit:
            interval += 1
        hint += f", or --ii {interval} with --max-processors {limit}"
    raise OutOfLimits("E402", message, hint, least)


def _check_path(problem: SchedulingProblem, limit: int | None) -> None:
    net = network(problem, {})
    if limit is None or net.critical <= limit:
        return
    message = f"the critical path takes {net.critical} cycles, more than --max-latency {limit}"
    path = " -> ".join(
        f"{net.kinds[net.kind[i]].split(' ')[0]} ({net.latency[i]})" for i in _critical_path(problem)
    )
    hint = f"the least that can be met is --max-latency {net.critical}: {path}"
    raise OutOfLimits("E403", message, hint, net.critical)


def _critical_path(problem: SchedulingProblem) -> list[int]:
    """Return the operations of a longest path that take cycles."""
    import networkx

    graph = problem.graph()
    graph.add_weighted_edges_from(((t.id, OUT, t.latency) for t in problem.operations), weight="cycles")
    path = networkx.dag_longest_path(graph, weight="cycles")
    index = {task.id: i for i, task in enumerate(problem.operations) if task.latency}
    return [index[id] for id in path if id in index]


def _both(
    problem: SchedulingProblem, most: tuple[Goal, int], max_latency: int, effort: Effort
) -> OutOfLimits:
    """Return the finding that each limit can be met, but not both."""
    few = solve(problem, [PROCESSORS, LATENCY], max_latency=max_latency, effort=effort)
    quick = solve(problem, [LATENCY], most=most, effort=effort)
    needed, proven = few.figures["processors"], few.optimal["processors"]
    net = network(problem, {})
    used = units_used(net, [few.start[id] for id in net.ids])
    kinds = " and ".join(f"{used[kind]} {kind}" for kind in CAU_KINDS if kind in used)
    message = (
        f"at interval {problem.interval} a latency of {max_latency} cycles takes "
        f"{'' if proven else 'as far as found '}{needed} CAUs ({kinds}), "
        f"more than --max-processors {most[1]}"
    )
    hint = (
        f"nearest: --max-processors {needed} at this latency, or --max-latency {quick.latency} with "
        f"--max-processors {most[1]}"
    )
    return OutOfLimits("E407", message, hint)
