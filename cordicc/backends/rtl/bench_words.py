"""The samples with which a bench tries a core, as words, and what the plan makes of them.

Corners of the ranges, the problem's own samples, others drawn at random from the workspace, small ones, and
words that stand for no number or are out of range, in a random order that is the same in every run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.backends.rtl.word_ports import Ports, PortWord
from cordicc.base.arrays import Floats, Words
from cordicc.ir.sampling import DEFAULT_SEED, Workspace, corners, draw, draw_by_size

Run = Callable[[Mapping[str, Floats]], Mapping[str, NDArray[Any]]]
"""Runs a plan: numbers of the inputs, shape (n,) each, to those of the outputs and `valid`."""

DEFAULT_COUNT = 500
"""Samples drawn at random unless told otherwise."""

_SEED = 17
"""Of the order, and of the words around an invalid one."""


@dataclass(frozen=True, slots=True)
class BenchWords:
    """Samples as words.

    Attributes:
        given: the words of each input, shape (n,), in the order of the ports.
        wanted: the words of each output.
        ok: shape (n,), whether a sample has outputs.
    """

    given: tuple[Words, ...]
    wanted: tuple[Words, ...]
    ok: NDArray[np.bool_]

    @property
    def count(self) -> int:
        """Samples."""
        return int(self.ok.size)


def bench_words(ports: Ports, workspace: Workspace, count: int, run: Run) -> BenchWords:
    """Return samples of all kinds for a core, and what leaves it.

    Args:
        ports: of the core.
        workspace: the ranges of its inputs, and the problem's own samples.
        count: own samples and those drawn at random; the others come besides.
        run: what computes the outputs.
    """
    given = _mixed([*_inside(ports, workspace, count), _outside(ports)])
    numbers = {}
    for port, words in zip(ports.inputs, given, strict=True):
        lo, hi = workspace.ranges[port.name]
        # The ends of a range are no words: the numbers of the first and the last may be beyond them.
        number = np.clip(np.ldexp(words.astype(np.float64), -port.format.fraction_bits), lo, hi)
        numbers[port.name] = np.where((words < port.least) | (words > port.most), np.nan, number)
    found = run(numbers)
    ok = np.asarray(found["valid"], dtype=np.bool_)
    wanted = tuple(port.format.encode(np.where(ok, found[port.name], np.nan)) for port in ports.outputs)
    return BenchWords(given, wanted, ok)


def _inside(ports: Ports, workspace: Workspace, count: int) -> list[tuple[Words, ...]]:
    """Return words of samples in range."""
    own = {name: np.asarray(column[:count]) for name, column in (workspace.rows or {}).items()}
    drawn = [corners(workspace.ranges), draw_by_size(workspace, count // 4)]
    if own:
        drawn.append(own)
    drawn.append(
        draw(workspace, count - min((column.size for column in own.values()), default=0), DEFAULT_SEED)
    )
    found = []
    for samples in drawn:
        words = (_words(port.format, samples[port.name]) for port in ports.inputs)
        found.append(tuple(np.clip(w, p.least, p.most) for w, p in zip(words, ports.inputs, strict=True)))
    return found


def _words(format_: FixedPoint, numbers: Floats) -> Words:
    return format_.encode(np.asarray(numbers, dtype=np.float64))


def _outside(ports: Ports) -> tuple[Words, ...]:
    """Return words of which one input is out of range each, or the invalid code, the others in range."""
    random = np.random.Generator(np.random.PCG64(_SEED))
    rows: list[list[int]] = []
    for at, port in enumerate(ports.inputs):
        largest = port.format.largest_word
        for word in dict.fromkeys((-port.invalid, port.least - 1, port.most + 1, -largest, largest)):
            if port.least <= word <= port.most or abs(word) > largest + (word < 0):
                continue
            row = [int(random.integers(p.least, p.most, endpoint=True)) for p in ports.inputs]
            row[at] = word
            rows.append(row)
    columns = np.array(rows, dtype=np.int64).reshape(len(rows), len(ports.inputs))
    return tuple(columns.T)


def _mixed(parts: Sequence[tuple[Words, ...]]) -> tuple[Words, ...]:
    """Return parts in a random order."""
    columns = [np.concatenate(each) for each in zip(*parts, strict=True)]
    size = columns[0].size if columns else 0
    order = np.random.Generator(np.random.PCG64(_SEED)).permutation(size)
    return tuple(column[order] for column in columns)


def hex_lines(columns: Sequence[tuple[PortWord, Words]], first: NDArray[np.bool_] | None = None) -> str:
    """Return samples as hexadecimal numbers, a line each: the first column in the last bits.

    Args:
        columns: ports with their words.
        first: a bit above all words.
    """
    bits = sum(port.width for port, _ in columns) + (first is not None)
    size = columns[0][1].size
    values = [0] * size if first is None else [int(bit) for bit in first]
    for port, words in reversed(columns):
        mask = (1 << port.width) - 1
        values = [value << port.width | int(word) & mask for value, word in zip(values, words, strict=True)]
    digits = -(-bits // 4)
    return "".join(f"{value:0{digits}x}\n" for value in values)


def csv_lines(columns: Sequence[tuple[str, Words]]) -> str:
    """Return words as decimal numbers separated by commas, under a header."""
    rows = zip(*(column.tolist() for _, column in columns), strict=True)
    return (
        "\n".join([",".join(name for name, _ in columns), *(",".join(map(str, row)) for row in rows)]) + "\n"
    )
