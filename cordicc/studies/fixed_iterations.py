"""The iterations of `cordicc.studies.iterations` in fixed point, row by row, by the kernels of the units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cordicc.arith.kernels import micro_rotations
from cordicc.arith.kernels.end_of_reach import end_of_reach
from cordicc.arith.kernels.micro_rotations import NearEnd
from cordicc.arith.kernels.shift_sequences import Sequence, StepTable, fixed, step_table
from cordicc.studies import scaled_kernels
from cordicc.studies.iterations import IterationRun, State, counted_angle

Kernel = Callable[..., tuple[Any, ...]]


@dataclass(frozen=True, slots=True)
class StateWords:
    """x, y, z and the target as integers in units of 2^-fraction_bits; the target None if there is none."""

    x: int
    y: int
    z: int
    target: int | None = None


def fixed_rows(
    mode: str, sequence: Sequence, run: IterationRun, fraction_bits: int
) -> tuple[StateWords, tuple[StateWords, ...]]:
    """Repeat a run on the start rounded to so many fraction bits, angles likewise.

    Args:
        mode: rotation, vectoring or implicit.
        sequence: that of the run, with at least one iteration.
        run: of `iterations.rotate`, `vector`, `implicit_by_eq9` or `implicit`, which says where to begin.
        fraction_bits: at most 40.

    Returns:
        The start, and the words after every iteration.
    """
    start = rounded(run.start, fraction_bits)
    table = step_table(sequence, fraction_bits)
    angles = tuple(fixed(counted_angle(sequence, s), fraction_bits) for s in sequence.shifts)
    table = replace(table, angles=angles, eta=sequence.eta or (0,) * len(angles))
    kernel = _kernel(mode, sequence)
    # The standard vectoring kernel starts with x >= 0; the mirror image takes the same decisions.
    turn_over = _mirror if run.mirrored or (kernel is micro_rotations.vector and start.x < 0) else _same
    words, rows = turn_over(start), []
    near = _near_end(sequence, start, fraction_bits)
    for i in range(len(angles)):
        words = _step(kernel, words, _part(table, i), near, with_target=mode == "implicit")
        rows.append(turn_over(words))
    return start, tuple(rows)


def _near_end(sequence: Sequence, start: StateWords, angle_bits: int) -> NearEnd | None:
    """Return where the kernel of a unit turns to the end of reach, for a block that just holds the start.

    None without a target, for the paper's rule, and for sequences of which no bound is known.
    """
    if start.target is None or sequence.eta:
        return None
    block_bits = max(abs(start.x), abs(start.y), abs(start.target)).bit_length()
    try:
        end = end_of_reach(sequence, block_bits, angle_bits)
    except ValueError:
        return None
    return NearEnd(math.ceil(end.height(0.0)), math.ceil(end.rise(0.0) + end.room(0.0)))


def rounded(state: State, fraction_bits: int) -> StateWords:
    """Return the state in units of 2^-fraction_bits, rounded to nearest."""
    x, y, z = (fixed(v, fraction_bits) for v in (state.x, state.y, state.z))
    return StateWords(x, y, z, None if state.target is None else fixed(state.target, fraction_bits))


def _kernel(mode: str, sequence: Sequence) -> Kernel:
    if mode == "implicit":
        if sequence.eta:
            return scaled_kernels.implicit_scaled
        return micro_rotations.implicit_root_free if sequence.root_free else micro_rotations.implicit
    if mode == "rotation":
        return scaled_kernels.rotate_scaled if sequence.root_free else micro_rotations.rotate
    return scaled_kernels.vector_scaled if sequence.root_free else micro_rotations.vector


def _part(table: StepTable, i: int) -> StepTable:
    """Return the table of one iteration."""
    one = slice(i, i + 1)
    return replace(
        table,
        shifts=table.shifts[one],
        angles=table.angles[one],
        target_factors=table.target_factors[one],
        stretched=table.stretched[one],
        eta=table.eta[one],
    )


def _step(
    kernel: Kernel, words: StateWords, table: StepTable, near: NearEnd | None, with_target: bool
) -> StateWords:
    operands = [words.x, words.y, words.target, words.z] if with_target else [words.x, words.y, words.z]
    told = [table] if near is None else [table, near]
    ends = kernel(*(np.array([v], dtype=object) for v in operands), *told)
    numbers = [int(v[0]) for v in ends]
    if with_target and kernel is not scaled_kernels.implicit_scaled:
        return StateWords(numbers[0], numbers[1], numbers[3], numbers[2])
    return StateWords(numbers[0], numbers[1], numbers[2], words.target)


def _same(words: StateWords) -> StateWords:
    return words


def _mirror(words: StateWords) -> StateWords:
    return replace(words, x=-words.x, z=-words.z)
