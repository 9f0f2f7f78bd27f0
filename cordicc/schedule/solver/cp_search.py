"""The exact solver: what CP-SAT proves of a goal, and the best schedule it finds, within fixed work.

FIFO words are bounded from below by two strategies, one after the other.  In one the solver assumes that no
value waits, and of each set of values that it finds to contradict this, a core, it lets one wait.  The other
is a tree search on the linear relaxation, which comes first where intervals are short, so that words nearly
are cycles.  Neither has a good schedule before the end, so neighbourhoods improve the best one at the same
time.  Other goals have a good schedule from the heuristics, and strategies that prove by linear relaxations
and conflicts in turns.

Everything is deterministic: one configuration, one seed, limits in deterministic time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from threading import Event
from typing import TYPE_CHECKING

from cordicc.schedule.solver import neighbourhoods
from cordicc.schedule.solver.cp_objective import Objective
from cordicc.schedule.solver.cp_program import Program, Space
from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.goals import Goal, figure
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem

if TYPE_CHECKING:
    from ortools.sat.python import cp_model

_SEED = 1
_SEARCHES = ("core", "max_lp", "default_lp")
"""Of the solver's strategies those that prove most here; one more worker improves the best schedule."""
_WORD_SEARCHES = {"core": 0.6, "lb_tree_search": 0.4}
"""The strategies for FIFO words, and their shares of the deterministic time."""
_PROOF = 2.0
"""Times the deterministic time of a search goes to proofs, and takes as long by the clock as neighbourhoods:
their programs are small, and what making them takes is hardly counted."""
_SHORT = 2
"""Interval up to which the linear relaxation proves most of the words."""
_BRIEF = 1.0
"""Deterministic time up to which several strategies would only prepare to search."""


@dataclass(frozen=True, slots=True)
class Work:
    """Limits of a search: deterministic time, and seconds as the emergency stop; threads to work in.

    Of FIFO words, which are searched from both sides, it is that of the neighbourhoods, see `_PROOF`.

    The answer does not depend on the threads.
    """

    deterministic: float
    seconds: float | None = None
    threads: int = 2


@dataclass(frozen=True, slots=True)
class Answer:
    """The best starts found, None if there are none, and their cost; `bound` of the goal.

    `struck`: the clock ended the search.
    """

    start: tuple[int, ...] | None
    cost: int
    bound: int
    proven: bool
    infeasible: bool
    struck: bool


def minimise(
    problem: SchedulingProblem,
    net: Network,
    goal: Goal,
    space: Space,
    work: Work,
    hint: Sequence[int] | None = None,
    floor: int = 0,
) -> Answer:
    """Return starts that minimise a goal within a space; `floor` is a known lower bound of it."""
    program = Program(problem, net, space, goal)
    objective = Objective(program)
    cost = objective.cost(goal)
    program.model.add(cost >= floor)
    for earlier, achieved in space.held:
        program.model.add(objective.cost(earlier) <= achieved)
    program.model.minimize(cost)
    if hint is not None:
        objective.hint(hint)
    clock = Clock(work)
    if goal.words and problem.measure == "entries":
        if hint is None:
            return _below(program, clock, floor)

        def improve(proven: Callable[[], bool]) -> Answer:
            def ended() -> bool:
                return proven() or clock.over

            start = neighbourhoods.improved(
                problem, net, goal, space, hint, work.deterministic, clock.solver, ended
            )
            cost = figure(problem, net, goal, start, max(space.latency[0], net.makespan(start)))
            return Answer(tuple(start), cost, floor, cost == floor, False, clock.over)

        return _from_both_sides(program, clock, floor, improve)
    brief = work.deterministic <= _BRIEF
    solver = clock.solver(work.deterministic, () if brief else _SEARCHES)
    solver.parameters.num_workers = 1 if brief else len(_SEARCHES) + 1
    solver.parameters.interleave_search = True
    return _answer(program, solver, clock, floor)


class Clock:
    """The limits of a search, and the solvers that keep them."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self._end = None if work.seconds is None else time.monotonic() + work.seconds

    @property
    def over(self) -> bool:
        """Whether the emergency stop struck."""
        return self._end is not None and time.monotonic() >= self._end

    def solver(self, deterministic: float, searches: Sequence[str] = ()) -> cp_model.CpSolver:
        """Return a solver for one worker with a limit in deterministic time."""
        from ortools.sat.python import cp_model

        solver = cp_model.CpSolver()
        solver.parameters.random_seed = _SEED
        solver.parameters.num_workers = 1
        solver.parameters.subsolvers.extend(searches)
        solver.parameters.max_deterministic_time = deterministic
        if self._end is not None:
            solver.parameters.max_time_in_seconds = max(0.01, self._end - time.monotonic())
        return solver


def _answer(program: Program, solver: cp_model.CpSolver, clock: Clock, floor: int) -> Answer:
    from ortools.sat.python import cp_model

    status = solver.solve(program.model)
    assert status != cp_model.MODEL_INVALID, program.model.validate()
    found = status in (cp_model.OPTIMAL, cp_model.FEASIBLE)
    proven = status in (cp_model.OPTIMAL, cp_model.INFEASIBLE)
    return Answer(
        start=tuple(solver.value(s) for s in program.start) if found else None,
        cost=round(solver.objective_value) if found else 0,
        bound=max(floor, -int(-solver.best_objective_bound // 1)) if status != cp_model.INFEASIBLE else floor,
        proven=proven,
        infeasible=status == cp_model.INFEASIBLE,
        struck=not proven and clock.over,
    )


def _below(program: Program, clock: Clock, floor: int) -> Answer:
    """Return what the strategies prove that bound FIFO words from below, one after the other."""
    order = [(strategy, _PROOF * share) for strategy, share in _WORD_SEARCHES.items()]
    if program.net.interval <= _SHORT:
        order.reverse()
    if clock.work.deterministic <= _BRIEF:
        order = [(order[0][0], 1.0)]
    best: Answer | None = None
    for strategy, share in order:
        solver = clock.solver(clock.work.deterministic * share, (strategy,))
        answer = _answer(program, solver, clock, floor)
        if answer.proven:
            return answer
        floor = max(floor, answer.bound)
        if best is None or (answer.start is not None and (best.start is None or answer.cost < best.cost)):
            best = answer
    assert best is not None
    return replace(best, bound=floor, proven=best.start is not None and best.cost == floor)


def _from_both_sides(
    program: Program, clock: Clock, floor: int, improve: Callable[[Callable[[], bool]], Answer]
) -> Answer:
    """Return what the cores prove, with the better schedule of both searches if that is not all.

    A proof ends the other search, whose result it makes needless: so the answer does not depend on which
    of them is ahead.
    """
    proven = Event()

    def prove() -> Answer:
        answer = _below(program, clock, floor)
        if answer.proven:
            proven.set()
        return answer

    with ThreadPoolExecutor(clock.work.threads) as pool:
        proof = pool.submit(prove)
        better = pool.submit(improve, proven.is_set)
        below, above = proof.result(), better.result()
    if below.proven:
        return below
    best = below if below.start is not None and below.cost < above.cost else above
    bound = max(below.bound, floor)
    return replace(best, bound=bound, proven=best.cost == bound, struck=below.struck or above.struck)
