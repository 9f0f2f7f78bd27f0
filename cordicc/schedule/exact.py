"""The exact solver: what CP-SAT proves of a goal, and the best schedule it finds, within fixed work.

FIFO words are minimised from below: the solver assumes that no value waits, and of each set of values that
it finds to contradict this, a core, it lets one wait.  That proves more than any other strategy here, but
has no schedule before the last core; so a large neighbourhood search improves the best one at the same
time.  Other goals have a good schedule from the heuristics, and strategies that prove by linear
relaxations and conflicts in turns.

Everything is deterministic: one configuration, one seed, limits in deterministic time.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from cordicc.schedule.goals import Goal
from cordicc.schedule.network import Network
from cordicc.schedule.problem import SchedulingProblem
from cordicc.schedule.program import Program, Space

if TYPE_CHECKING:
    from ortools.sat.python import cp_model

_SEED = 1
_SEARCHES = ("core", "max_lp", "default_lp")
"""Of the solver's strategies those that prove most here; one more worker improves the best schedule."""
_BRIEF = 1.0
"""Deterministic time up to which several strategies would only prepare to search."""
_NEIGHBOURHOODS = 0.5
"""Share of the deterministic time for the neighbourhood search; a unit of it takes longer."""


@dataclass(frozen=True, slots=True)
class Work:
    """Limits of a search: deterministic time, and seconds as the emergency stop; threads do not matter."""

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
    cost = program.cost(goal)
    program.model.add(cost >= floor)
    for earlier, figure in space.held:
        program.model.add(program.cost(earlier) <= figure)
    program.model.minimize(cost)
    if hint is not None:
        program.hint(hint)
    if goal.words and problem.measure == "entries":
        return _from_both_sides(program, work, floor)
    brief = work.deterministic <= _BRIEF
    solver = _solver(work, 1 if brief else len(_SEARCHES) + 1, () if brief else _SEARCHES)
    solver.parameters.interleave_search = True
    return _answer(program, solver, work, floor)


def _solver(work: Work, workers: int, searches: Sequence[str], share: float = 1.0) -> cp_model.CpSolver:
    from ortools.sat.python import cp_model

    solver = cp_model.CpSolver()
    solver.parameters.random_seed = _SEED
    solver.parameters.num_workers = workers
    solver.parameters.subsolvers.extend(searches)
    solver.parameters.max_deterministic_time = work.deterministic * share
    if work.seconds is not None:
        solver.parameters.max_time_in_seconds = work.seconds
    return solver


def _answer(program: Program, solver: cp_model.CpSolver, work: Work, floor: int) -> Answer:
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
        struck=not proven and work.seconds is not None and solver.wall_time >= work.seconds,
    )


def _from_both_sides(program: Program, work: Work, floor: int) -> Answer:
    """Return what the cores prove, with the better schedule of the two searches if that is not all.

    A proof stops the other search, whose result it makes needless: so the answer does not depend on
    which of them is ahead, nor on the number of threads.
    """
    below = _solver(work, 1, ["core"])
    above = _solver(work, 1, (), _NEIGHBOURHOODS)
    above.parameters.use_lns_only = True
    above.parameters.interleave_search = True

    def prove() -> Answer:
        answer = _answer(program, below, work, floor)
        if answer.proven:
            above.stop_search()
        return answer

    with ThreadPoolExecutor(work.threads) as pool:
        proof = pool.submit(prove)
        if work.threads == 1 and proof.result().proven:
            return proof.result()
        other = pool.submit(_answer, program, above, work, floor)
        proved, improved = proof.result(), other.result()
    if proved.proven:
        return proved
    best = min((each for each in (improved, proved) if each.start is not None), key=_cost, default=proved)
    bound = max(proved.bound, improved.bound)
    struck = proved.struck or improved.struck
    return replace(best, bound=bound, proven=best.start is not None and best.cost == bound, struck=struck)


def _cost(answer: Answer) -> int:
    return answer.cost
