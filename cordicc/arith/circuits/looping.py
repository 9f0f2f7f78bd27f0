"""Steps that are made one after the other with the hardware of one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.cell_delays import Clocking
from cordicc.arith.circuits.circuit import INDEX, Loop

State = tuple[CircuitSignal, tuple[int, int]]
"""How a state begins, and the least and the largest value that it ever has."""


def looped(
    b: CircuitBuilder,
    steps: int,
    states: Mapping[str, State],
    kept: Mapping[str, CircuitSignal],
    body: Callable[[CircuitBuilder, Mapping[str, CircuitSignal]], Mapping[str, CircuitSignal]],
) -> dict[str, CircuitSignal]:
    """Return states after a step has been made so many times, in as many cycles.

    Args:
        b: the builder.
        steps: how many times.
        states: by name.
        kept: what the steps take besides, by name; constants are constants there.
        body: returns the states of the next step, from the states, what is kept, and `INDEX`.
    """
    inner = CircuitBuilder("step", Clocking(math.inf, b.clocking.delays))
    inputs = {name: inner.input(name, *span) for name, (_, span) in states.items()}
    steady = {name: signal for name, signal in kept.items() if signal.lo < signal.hi}
    fixed = {name: inner.of(signal.lo) for name, signal in kept.items() if name not in steady}
    inputs |= {name: inner.input(name, signal.lo, signal.hi) for name, signal in steady.items()}
    inputs[INDEX] = inner.input(INDEX, 0, steps - 1)
    following = body(inner, inputs | fixed)
    for name, (_, (lo, hi)) in states.items():
        inner.output(name, inner.narrowed(following[name], lo, hi))
    loop = Loop(inner.circuit(), tuple(states), tuple(steady), steps)
    operands = [*(signal for signal, _ in states.values()), *steady.values()]
    spans = [span for _, span in states.values()]
    return dict(zip(states, b.turning(loop, operands, spans, inner.latest_ns()), strict=True))


def too_fast(b: CircuitBuilder) -> bool:
    """Tell whether a step takes longer than the clock allows."""
    return b.step_ns > b.clocking.free_ns
