"""The scheduler: goals in lexicographic order, each by the heuristic, its bound and the exact solver.

Every goal is a stage.  Candidates come from the heuristics; a bound in closed form ends the stage if a
candidate meets it, else the exact solver improves the best one or proves it.  What a stage achieved is
held in the later ones.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from cordicc.schedule.solver import cp_search, fifo_lp
from cordicc.schedule.solver.cp_program import Space
from cordicc.schedule.solver.dependences import Network, network
from cordicc.schedule.solver.goals import LATENCY, Goal, counted_kinds, figure, units_used
from cordicc.schedule.solver.latency_bounds import fewest_by_kind, latency_bound, raised
from cordicc.schedule.solver.modulo_list import list_schedule
from cordicc.schedule.solver.scheduling_problem import (
    InfeasibleError,
    Schedule,
    SchedulingProblem,
    fifo_words,
)
from cordicc.schedule.solver.shift import improve

MOST_EXACT = 1500
"""Operations beyond which only the heuristics and the bounds work."""
_MOST_EXACT_WORDS = 400
_MOST_SPLITS = 32


@dataclass(frozen=True, slots=True)
class Effort:
    """Work limits in deterministic time, for goals without and with words and the binding; seconds in all.

    The result does not depend on the threads.
    """

    schedule: float = 10.0
    words: float = 5.0
    binding: float = 4.0
    seconds: float | None = None
    threads: int = 2

    def times(self, factor: float) -> Effort:
        """Return work limits so many times as large; seconds stay as they are."""
        schedule, words, binding = (factor * work for work in (self.schedule, self.words, self.binding))
        return replace(self, schedule=schedule, words=words, binding=binding)


def solve(
    problem: SchedulingProblem,
    goals: Sequence[Goal],
    *,
    max_latency: int | None = None,
    most: tuple[Goal, int] | None = None,
    effort: Effort | None = None,
) -> Schedule:
    """Return a schedule that is least in the goals, one after the other.

    Args:
        problem: operations, values, interval and units.
        goals: with distinct names.
        max_latency: cycles that the schedule may take.
        most: a goal in units alone, and what it may cost.
        effort: the work to be done at most.

    Raises:
        ValueError: a malformed problem.
        InfeasibleError: no schedule, or none was found, within the limits.
    """
    problem.check()
    if problem.interval == 1:
        return _at_interval_one(problem, goals, max_latency, most)
    search = _Search(problem, goals, max_latency, most, effort or Effort())
    if most is not None:
        goal, limit = most
        found, bound = search.stage(goal)
        if found > limit:
            raise InfeasibleError(
                f"{goal.name}: {'at least' if bound > limit else 'found no fewer than'} {max(bound, found)}"
            )
        if goal.name != goals[0].name:
            search.loosen(goal, limit)
    for goal in goals:
        search.achieve(goal)
    return search.solution()


def _at_interval_one(
    problem: SchedulingProblem, goals: Sequence[Goal], max_latency: int | None, most: tuple[Goal, int] | None
) -> Schedule:
    """Every operation has a unit of its own, so units cost the same whatever the schedule."""
    net = network(problem)
    units = fewest_by_kind(net)
    if most is not None:
        needed = sum(weight * units.get(kind, 0) for kind, weight in most[0].units.items())
        if needed > most[1]:
            raise InfeasibleError(f"{most[0].name}: at least {needed}")
    first = next((goal for goal in goals if goal.latency or goal.words), None)
    by_words = first is not None and first.words > 0
    solved = fifo_lp.solve(
        problem, "fifo" if by_words else "latency", max_latency, first.width if by_words and first else None
    )
    start = [solved.start[id] for id in net.ids]
    figures = {goal.name: figure(problem, net, goal, start, solved.latency) for goal in goals}
    bounds = {
        goal.name: solved.bounds["fifo_words"] if goal.name == "fifo_words" else figures[goal.name]
        for goal in goals
    }
    optimal = {name: bounds[name] == figures[name] for name in figures}
    return Schedule(solved.start, solved.latency, solved.fifo_words, optimal, bounds, figures)


class _Search:
    """The state between stages: units and latency still allowed, goals held, the best schedule."""

    def __init__(
        self,
        problem: SchedulingProblem,
        goals: Sequence[Goal],
        max_latency: int | None,
        most: tuple[Goal, int] | None,
        effort: Effort,
    ) -> None:
        self._problem, self._effort = problem, effort
        self._end = None if effort.seconds is None else time.monotonic() + effort.seconds
        counts = problem.counts()
        self._net = net = network(problem, {})
        self._fewest = fewest_by_kind(net)
        counted = counted_kinds([*goals, *([most[0]] if most else [])])
        counted |= {kind for kind, limit in problem.limits.items() if limit < counts.get(kind, 0)}
        self._units = {
            kind: (self._fewest[kind], min(problem.limits.get(kind, count), count))
            for kind, count in counts.items()
            if kind in counted
        }
        self._horizon = sum(net.latency) + (len(net.ids) + 1) * net.interval
        self._latency = (net.critical, self._horizon if max_latency is None else max_latency)
        self._limit = max_latency
        if max_latency is not None and max_latency < net.critical:
            raise InfeasibleError(f"the longest path takes {net.critical} cycles, more than {max_latency}")
        self._held: list[tuple[Goal, int]] = []
        self._best: list[int] | None = None
        self._figures: dict[str, int] = {}
        self._bounds: dict[str, int] = {}
        self._struck = False
        if max_latency is not None and self._fixed():
            self._meet(max_latency)

    def _fixed(self) -> bool:
        """Tell whether limits of the problem can keep the latency from being met."""
        return any(most < self._problem.counts()[kind] for kind, (_, most) in self._units.items())

    def _meet(self, latency: int) -> None:
        """Find any schedule within the problem's own limits and a latency."""
        self._latency = (self._net.critical, self._horizon)
        found, bound = self.stage(LATENCY)
        if found > latency:
            word = "at least" if bound > latency else "found no fewer than"
            raise InfeasibleError(f"latency: {word} {max(bound, found)}")
        self._latency = (self._net.critical, latency)

    def loosen(self, goal: Goal, limit: int) -> None:
        """Hold a goal at a limit."""
        self._hold(goal, limit)

    def achieve(self, goal: Goal) -> None:
        """Minimise a goal and hold what was achieved."""
        found, bound = self.stage(goal)
        if self._shortened():
            found = self._cost(goal, self._best or [])
            bound = min(found, self._floor(goal))
        self._figures[goal.name], self._bounds[goal.name] = found, bound
        self._hold(goal, found)

    def _shortened(self) -> bool:
        """Hold the latency of the best schedule if it is less than the one achieved before."""
        assert self._best is not None
        latency = self._net.makespan(self._best)
        if latency >= self._figures.get(LATENCY.name, 0):
            return False
        self._figures[LATENCY.name] = latency
        self._latency = (latency, latency)
        return True

    def solution(self) -> Schedule:
        """Return what all stages achieved."""
        assert self._best is not None
        start = dict(zip(self._net.ids, self._best, strict=True))
        # Each goal is proven for what those before it achieved: a figure at its bound is the least.
        optimal = {name: self._bounds[name] == achieved for name, achieved in self._figures.items()}
        latency = self._latency_of(self._best)
        words = fifo_words(self._problem, start, latency)
        return Schedule(start, latency, words, optimal, self._bounds, self._figures, self._struck)

    def stage(self, goal: Goal) -> tuple[int, int]:
        """Return the least cost of a goal that was found, and its bound; keep the schedule."""
        floor = self._floor(goal)
        least = None if self._best is None else self._cost(goal, self._best)
        if least is None or least > floor:
            for start in self._candidates(goal, floor):
                if self._allowed(start):
                    cost = self._cost(goal, start)
                    if least is None or cost < least:
                        self._best, least = start, cost
                    if least == floor:
                        break
        if least == floor:
            return floor, floor
        count = len(self._net.ids)
        if count > (_MOST_EXACT_WORDS if goal.words else MOST_EXACT) and least is not None:
            return least, floor
        return self._exact(goal, floor, least)

    def _exact(self, goal: Goal, floor: int, least: int | None) -> tuple[int, int]:
        most = self._latency[1]
        if goal is LATENCY and self._best is not None:
            most = min(most, self._net.makespan(self._best))
        net = self._capped(1)
        head, tail = raised(net)
        words = self._effort.words if goal.words else self._effort.schedule
        left = None if self._end is None else max(0.1, self._end - time.monotonic())
        space = Space(head, tail, (self._latency[0], most), self._units, tuple(self._held))
        work = cp_search.Work(words, left, self._effort.threads)
        answer = cp_search.minimise(self._problem, self._net, goal, space, work, self._best, floor)
        self._struck |= answer.struck
        if answer.start is not None:
            start = list(answer.start)
            if least is None or self._cost(goal, start) < least:
                self._best, least = start, self._cost(goal, start)
        if self._best is None or least is None:
            raise InfeasibleError("no schedule was found within the work limit")
        return least, min(least, least if answer.proven else answer.bound)

    def _hold(self, goal: Goal, cost: int) -> None:
        """Keep a goal at a cost: narrow units and latency where that says the same."""
        weights = {kind: w for kind, w in goal.units.items() if kind in self._units}
        if goal.words or (goal.latency and weights):
            self._held.append((goal, cost))
        elif goal.latency:
            self._latency = (cost // goal.latency, cost // goal.latency)
        else:
            least = sum(weight * self._units[kind][0] for kind, weight in weights.items())
            for kind, weight in weights.items():
                low, high = self._units[kind]
                self._units[kind] = (low, min(high, low + (cost - least) // weight))
            if sum(high > low for low, high in (self._units[kind] for kind in weights)) > 1:
                self._held.append((goal, cost))

    def _allowed(self, start: Sequence[int]) -> bool:
        used = units_used(self._net, start)
        latency = self._latency_of(start)
        return (
            latency <= self._latency[1]
            and all(used[kind] <= most for kind, (_, most) in self._units.items())
            and all(figure(self._problem, self._net, g, start, latency) <= cost for g, cost in self._held)
        )

    def _cost(self, goal: Goal, start: Sequence[int]) -> int:
        return figure(self._problem, self._net, goal, start, self._latency_of(start))

    def _latency_of(self, start: Sequence[int]) -> int:
        """Return the cycle in which the outputs leave: when all is done, or when they have to."""
        return max(self._net.makespan(start), self._latency[0])

    def _capped(self, end: int, only: Mapping[str, int] | None = None) -> Network:
        """Return the network with the units at one end of their ranges, or with those given."""
        limits = {kind: span[end] for kind, span in self._units.items()} if only is None else only
        return network(self._problem, limits)

    def _floor(self, goal: Goal) -> int:
        """Return a lower bound of a goal in closed form."""
        bound = 0
        for kind, weight in goal.units.items():
            if weight and kind in self._units:
                bound += weight * self._least_units(kind)
        if goal.latency:
            bound += goal.latency * max(self._latency[0], latency_bound(self._capped(1)))
        if goal.words and goal.width is None and self._latency[0] == self._latency[1]:
            cycles = fifo_lp.least_cycles(self._problem, self._latency[1])
            whole = self._problem.interval if self._problem.measure == "entries" else 1
            bound += goal.words * -(-cycles // whole)
        return bound

    def _least_units(self, kind: str) -> int:
        """Return the fewest units of a kind with which the latency can be kept, as far as bounds tell."""
        low, high = self._units[kind]
        if self._latency[1] >= self._horizon:
            return low
        while low < high:
            middle = (low + high) // 2
            if latency_bound(self._capped(0, {kind: middle})) <= self._latency[1]:
                high = middle
            else:
                low = middle + 1
        return low

    def _candidates(self, goal: Goal, floor: int) -> Iterator[list[int]]:
        if goal.words:
            yield from self._thrifty(goal)
        elif goal.latency:
            for units in self._splits():
                net = network(self._problem, units)
                if (start := list_schedule(net, latency_bound(net))) is not None:
                    yield start
        if goal.units:
            for start in self._few_units(goal):
                yield self._improved(goal, start) if goal.words else start

    def _improved(self, goal: Goal, start: Sequence[int]) -> list[int]:
        """Return a schedule with fewer words that uses no more units."""
        net = network(self._problem, units_used(self._net, start))
        weights = [goal.word_weight(value.name) for value in self._problem.values]
        return improve(self._problem, net, start, self._latency_of(start), weights)

    def _splits(self) -> Iterator[dict[str, int]]:
        """Yield numbers of units within the ranges and the goals held."""
        units = {kind: most for kind, (_, most) in self._units.items()}
        shared = [goal for goal, _ in self._held if goal.units and not goal.words and not goal.latency]
        if not shared:
            yield units
            return
        goal, cost = next((g, c) for g, c in self._held if g is shared[0])
        kinds = [kind for kind in goal.units if kind in self._units]
        first, rest = kinds[0], kinds[1:]
        low, high = self._units[first]
        for count in range(low, min(high, low + _MOST_SPLITS) + 1):
            left = cost - goal.units[first] * count
            chosen = dict(units)
            chosen[first] = count
            for kind in rest:
                others = sum(goal.units[k] * self._units[k][0] for k in rest if k != kind)
                chosen[kind] = min(self._units[kind][1], (left - others) // goal.units[kind])
            if all(chosen[kind] >= self._units[kind][0] for kind in kinds):
                yield chosen

    def _few_units(self, goal: Goal) -> Iterator[list[int]]:
        """Yield schedules with few units: the bounds', then more where that shortens most."""
        kinds = [kind for kind, weight in goal.units.items() if weight and kind in self._units]
        units = {kind: most for kind, (_, most) in self._units.items()}
        units |= {kind: self._least_units(kind) for kind in kinds}
        while True:
            net = network(self._problem, units)
            start = list_schedule(net, min(self._latency[1], self._horizon))
            if start is not None:
                yield start
                if net.makespan(start) <= self._latency[1]:
                    return
            open_kinds = [kind for kind in kinds if units[kind] < self._units[kind][1]]
            if not open_kinds:
                return
            tried = []
            for kind in open_kinds:
                step = max(1, units[kind] // 16)
                more = {**units, kind: min(units[kind] + step, self._units[kind][1])}
                wider = network(self._problem, more)
                longer = list_schedule(wider, self._latency[1])
                reached = self._horizon if longer is None else wider.makespan(longer)
                tried.append((reached, kind, more))
            units = min(tried, key=lambda item: item[:2])[2]

    def _thrifty(self, goal: Goal) -> Iterator[list[int]]:
        net = self._capped(1)
        if all(capacity is None for capacity in net.capacity):
            # With units for all, the least cycles of waiting are close to the fewest words.
            first: fifo_lp.First = "latency" if self._latency[1] == net.critical else "fifo"
            solved = fifo_lp.solve(self._problem, first, self._latency[1], goal.width)
            yield self._improved(goal, [solved.start[id] for id in net.ids])
        if self._best is not None:
            yield self._improved(goal, self._best)
            if len(net.ids) > MOST_EXACT:
                return
        bound = latency_bound(net) if self._best is None else self._latency[1]
        if (start := list_schedule(net, bound)) is not None:
            yield self._improved(goal, start)
