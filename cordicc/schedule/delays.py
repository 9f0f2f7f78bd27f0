"""From a schedule to FIFO segments."""

from __future__ import annotations

from collections.abc import Mapping

from cordicc.plan.model import Fifo
from cordicc.schedule.solver.scheduling_problem import Schedule, SchedulingProblem, Sink, waits


def delays(problem: SchedulingProblem, schedule: Schedule, widths: Mapping[str, int]) -> tuple[Fifo, ...]:
    """Return the FIFOs that delay every value to its consumers; `widths` in bits, by value.

    A value that consumers take after d1 < d2 < ... cycles gets one segment per step between these
    taps, with an entry for each sample that may be in it; a consumer without a wait takes the value
    directly.  Ids f1, f2, ... follow the order of the values, then of the taps.
    """
    wait = waits(problem, schedule.start, schedule.latency)
    fifos: list[Fifo] = []
    for value in problem.values:
        taps: dict[int, list[Sink]] = {}
        for sink in value.consumers:
            assert wait[sink] >= 0, f"{'.'.join(sink)} takes '{value.name}' before it is ready"
            taps.setdefault(wait[sink], []).append(sink)
        cycles = sorted(tap for tap in taps if tap > 0)
        reached = 0
        source = value.name if value.producer is None else value.producer
        for position, tap in enumerate(cycles):
            id = f"f{len(fifos) + 1}"
            onward = [f"f{len(fifos) + 2}"] if position + 1 < len(cycles) else []
            sinks = (*(".".join(sink) for sink in taps[tap]), *onward)
            fifos.append(
                Fifo(
                    id, value.name, source, sinks, -(-(tap - reached) // problem.interval), widths[value.name]
                )
            )
            reached, source = tap, id
    return tuple(fifos)
