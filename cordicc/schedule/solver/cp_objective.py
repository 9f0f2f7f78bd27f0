"""What a constraint program minimises: the goals as expressions, and the schedule from which it starts.

FIFO words are added to the program when the first goal asks for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cordicc.schedule.solver.cp_program import Program
from cordicc.schedule.solver.fifo_entries import FifoWords
from cordicc.schedule.solver.goals import Goal
from cordicc.schedule.solver.symmetry import least


class Objective:
    """The goals of a program."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._words: FifoWords | None = None

    def cost(self, goal: Goal) -> Any:
        """Return the expression of a goal."""
        program = self._program
        terms = [weight * program.units[kind] for kind, weight in goal.units.items() if kind in program.units]
        terms.append(goal.latency * program.latency)
        if goal.words:
            if self._words is None:
                self._words = FifoWords(program)
            terms += [goal.word_weight(name) * count for name, count in self._words.count.items()]
        return sum(terms)

    def hint(self, start: Sequence[int]) -> None:
        """Start the search from a schedule, completed by what follows from it."""
        from ortools.sat.python import cp_model

        program = self._program
        now = least(start if self._words is None else self._words.early(start), program.exchanges)
        latency = max(program.space.latency[0], program.net.makespan(now))
        given = list(zip([*program.start, program.latency], [*now, latency], strict=True))
        fixed = program.model.clone()
        for variable, number in given:
            fixed.add(variable == number)
        solver = cp_model.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.max_deterministic_time = 1.0
        if solver.solve(fixed) in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            for index, number in enumerate(solver.response_proto.solution):
                program.model.add_hint(program.model.get_int_var_from_proto_index(index), number)
            return
        for variable, number in given:
            program.model.add_hint(variable, number)
