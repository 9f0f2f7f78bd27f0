"""Fewer FIFO words by large neighbourhoods: some operations move at a time, in the best way there is.

A neighbourhood is a set of operations that are near one another in the graph or in time, or that share
units.  Its program has the values that they touch; the other ends of these stay, and units that the
rest takes are taken.  A schedule that is as good as the one before is kept as well, which leads out of
dead ends.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from cordicc.schedule.solver.cp_objective import Objective
from cordicc.schedule.solver.cp_program import Program, Space
from cordicc.schedule.solver.dependences import Network, network
from cordicc.schedule.solver.goals import Goal, figure, units_used
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem

if TYPE_CHECKING:
    from ortools.sat.python import cp_model

_SEED = 1
_LEAST_SIZE, _MOST_SIZE = 12, 60
_EACH = 0.1
"""Deterministic time for a neighbourhood, at most."""
_OVERHEAD = 0.02
"""Deterministic time that building the program of a neighbourhood counts as."""


def improved(
    problem: SchedulingProblem,
    net: Network,
    goal: Goal,
    space: Space,
    start: Sequence[int],
    work: float,
    solver: Callable[[float], cp_model.CpSolver],
    ended: Callable[[], bool],
) -> list[int]:
    """Return a schedule of the same latency that is at least as good by a goal in FIFO words.

    Args:
        problem: operations and values.
        net: its network.
        goal: what is minimised.
        space: windows; units beyond those that the schedule uses are not used.
        start: the schedule.
        work: deterministic time.
        solver: makes a solver with a limit in deterministic time.
        ended: asked between neighbourhoods; true ends the search.
    """
    search = _Improvement(problem, net, goal, space, start)
    for members in search.neighbourhoods():
        if work <= 0 or ended():
            break
        work -= search.move(members, solver(min(_EACH, work))) + _OVERHEAD
    return search.start


class _Improvement:
    """A schedule and what may change of it; neighbourhoods grow while they are solved to the end."""

    def __init__(
        self, problem: SchedulingProblem, net: Network, goal: Goal, space: Space, start: Sequence[int]
    ) -> None:
        self._problem, self._net, self._space = problem, net, space
        # Units and latency stay, so that words alone count, those of the goals before too.
        held = [earlier for earlier, _ in space.held if earlier.words]
        self._goals = [replace(each, units={}, latency=0) for each in (goal, *held)]
        self.start = list(start)
        self._latency = max(space.latency[0], net.makespan(start))
        self._random = random.Random(_SEED)
        self._size = _LEAST_SIZE
        counts, used = problem.counts(), units_used(net, start)
        # Goals in units stay met if no kind uses more units than now.
        self._units = {kind: used[kind] for kind in space.units if used[kind] < counts[kind]}
        self._index = {id: index for index, id in enumerate(net.ids)}
        self._near: list[dict[int, None]] = [{} for _ in net.ids]
        for value in problem.values:
            ends = [self._index[id] for id in (value.producer, *value.takers()) if id in self._index]
            for end in ends:
                self._near[end].update((other, None) for other in ends if other != end)

    def neighbourhoods(self) -> Iterator[set[int]]:
        """Yield sets of operations without end."""
        shared = [i for i in range(len(self._net.ids)) if self._net.kinds[self._net.kind[i]] in self._units]
        while True:
            yield self._ball(self._random.randrange(len(self._net.ids)))
            yield self._nearest(range(len(self._net.ids)))
            if shared:
                kind = self._net.kind[self._random.choice(shared)]
                several = self._nearest([i for i in shared if self._net.kind[i] == kind], 3)
                yield several.union(*(self._near[i] for i in sorted(several)))

    def _ball(self, centre: int) -> set[int]:
        """Return the operations around one in the graph."""
        found = [centre]
        known = {centre}
        for index in found:
            around = [other for other in self._near[index] if other not in known]
            self._random.shuffle(around)
            for other in around[: self._size - len(found)]:
                found.append(other)
                known.add(other)
        return known

    def _nearest(self, among: Sequence[int], part: int = 1) -> set[int]:
        """Return those of some operations that start around the same time as one of them."""
        centre = self.start[self._random.choice(among)]
        ranked = sorted(among, key=lambda i: (abs(self.start[i] - centre), i))
        return set(ranked[: max(2, self._size // part)])

    def move(self, members: set[int], solver: cp_model.CpSolver) -> float:
        """Move some operations in the best way that the solver finds; return the deterministic time."""
        from ortools.sat.python import cp_model

        program, inside = self._program(members)
        status = solver.solve(program.model)
        if status in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            for position, index in enumerate(inside):
                self.start[index] = solver.value(program.start[position])
        finished = status in (cp_model.OPTIMAL, cp_model.INFEASIBLE)
        self._size = min(self._size + 1, _MOST_SIZE) if finished else max(self._size * 3 // 4, _LEAST_SIZE)
        return solver.deterministic_time

    def _program(self, members: set[int]) -> tuple[Program, list[int]]:
        """Return the program of a neighbourhood and the operations in it, by its own numbers."""
        ids = {self._net.ids[i] for i in members}
        values = [v for v in self._problem.values if v.producer in ids or ids.intersection(v.takers())]
        ends = {id for value in values for id in (value.producer, *value.takers())}
        inside = sorted(members | {self._index[id] for id in ends if id in self._index})
        part = SchedulingProblem(
            tuple(self._problem.operations[i] for i in inside),
            tuple(values),
            self._problem.interval,
            measure=self._problem.measure,
        )
        lasting = {self._net.kinds[kind] for kind in self._net.lasting}
        taken: dict[str, list[int]] = {kind: [0] * self._net.interval for kind in self._units}
        placed: dict[str, list[tuple[int, int]]] = {kind: [] for kind in self._units if kind in lasting}
        for index in sorted(set(range(len(self.start))).difference(inside)):
            kind = self._net.kinds[self._net.kind[index]]
            slot = self.start[index] % self._net.interval
            if kind in placed:
                placed[kind].append((slot, self._net.busy[index]))
            elif kind in taken:
                taken[kind][slot] += 1
        last = self._latency
        space = Space(
            [self._space.head[i] if i in members else self.start[i] for i in inside],
            [self._space.tail[i] if i in members else last - self.start[i] for i in inside],
            (last, last),
            {kind: (most, most) for kind, most in self._units.items()},
            [(goal, 0) for goal in self._goals[1:]],
            {kind: counts for kind, counts in taken.items() if kind not in placed},
            placed,
        )
        program = Program(part, network(part, {}), space, self._goals[0], lean=True)
        objective = Objective(program)
        now = [self.start[i] for i in inside]
        for goal in self._goals:
            program.model.add(objective.cost(goal) <= figure(part, program.net, goal, now, last))
        program.model.minimize(objective.cost(self._goals[0]))
        return program, inside
