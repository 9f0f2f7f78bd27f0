"""Exhaustive search, for problems small enough for it."""

from collections.abc import Iterator

from cordicc.schedule.solver.scheduling_problem import SchedulingProblem


def every_schedule(problem: SchedulingProblem, latency: int) -> Iterator[dict[str, int]]:
    """Yield all starts that respect the dependences and finish by `latency`."""
    tasks = problem.order()
    cycles = {task.id: task.latency for task in tasks}
    before = {task.id: [p for p, taker in problem.edges() if taker == task.id] for task in tasks}

    def extend(start: dict[str, int], depth: int) -> Iterator[dict[str, int]]:
        if depth == len(tasks):
            yield start
            return
        task = tasks[depth]
        first = max((start[p] + cycles[p] for p in before[task.id]), default=0)
        for cycle in range(first, latency - task.latency + 1):
            yield from extend({**start, task.id: cycle}, depth + 1)

    yield from extend({}, 0)
