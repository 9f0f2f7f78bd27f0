"""One sample of a plan's inputs, by its number: a row of a file, or one of those that `simulate` draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.emulate.sample_columns import Columns
from cordicc.emulate.sample_tables import PART_ROWS, read_table
from cordicc.ir.sampling import draw_parts
from cordicc.plan.origin import PlanProblem


@dataclass(frozen=True, slots=True)
class PickedSample:
    """A sample: its number, from 0, among what, in words; the numbers by input; warnings of its file."""

    number: int
    among: str
    numbers: Mapping[str, float]
    warnings: tuple[Diagnostic, ...] = ()


def drawn_sample(problem: PlanProblem, number: int, count: int, seed: int) -> PickedSample:
    """Return one of the samples that `simulate` draws; raises InvalidInput (E619) if there is no such one."""
    if number >= count:
        raise _no_such_sample(number, count, "only {} drawn", None, "; --random N draws more")
    begin = 0
    for part in draw_parts(problem.workspace, count, seed, PART_ROWS):
        size = min(PART_ROWS, count - begin)
        if number < begin + size:
            numbers = {name: float(column[number - begin]) for name, column in part.items()}
            return PickedSample(number, f"{count} drawn with seed {seed}", numbers)
        begin += size
    raise AssertionError(number)


def sample_of_file(problem: PlanProblem, path: Path, number: int) -> PickedSample:
    """Return a row of a file.

    Raises:
        InvalidInput: the file cannot be read, or has no such row (E619).
    """
    table = read_table(path, Columns(list(problem.input_names)))
    begin = 0
    for part in table.parts:
        size = max((column.size for column in part.values()), default=0)
        if number < begin + size:
            numbers = {name: float(part[name][number - begin]) for name in problem.input_names}
            return PickedSample(number, path.name, numbers, tuple(table.warnings))
        begin += size
    raise _no_such_sample(number, begin, "the file has {}", Source(str(path), ""), "")


def _no_such_sample(
    number: int, count: int, there_are: str, source: Source | None, more: str
) -> InvalidInput:
    """Return the error of a number that is too large."""
    samples = there_are.format(f"{count} sample{'s' * (count != 1)}" if count else "no sample")
    known = "" if not count else "count from 0, to " + str(count - 1)
    hint = f"samples {known}{more}" if known else None
    return InvalidInput(
        [Diagnostic("E619", f"there is no sample {number}: {samples}", None, hint, source=source)]
    )
