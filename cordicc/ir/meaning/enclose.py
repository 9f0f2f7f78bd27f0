"""Ranges of operations over closed intervals, rounded outwards: `Interval` and `evaluate`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cordicc.ir.meaning.enclosures import ENCLOSURES
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.ops import OPS

__all__ = ["Interval", "evaluate"]


def evaluate(
    op: str, params: Mapping[str, Any] | Sequence[Any], operands: Sequence[Interval | None]
) -> tuple[Interval | None, ...]:
    """Enclose every result of an operation on operands in intervals.

    Args:
        op: any operation of the graph but `input`.
        params: its parameters, by name or in the order of the operation's definition.
        operands: an interval each, or None for one that never has a value.

    Returns:
        An interval for each result, over the operands for which it has a value; None where it has a
        value for none of them.

    Raises:
        ValueError: unknown operation.
    """
    if op not in ENCLOSURES:
        raise ValueError(f"no enclosure for operation {op!r}")
    definition = OPS[op]
    if any(operand is None for operand in operands):
        return (None,) * len(definition.results)
    named = params if isinstance(params, Mapping) else definition.named(params)
    result = ENCLOSURES[op](*operands, **named)
    return result if isinstance(result, tuple) else (result,)
