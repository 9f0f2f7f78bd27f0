"""The proof of the stream around a core: what its properties see of the inside, and where that is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cordicc.backends.rtl.core import Core
from cordicc.backends.rtl.slots import RING_SLOTS


def is_proven(core: Core) -> bool:
    """Tell whether the package has a proof: it is by induction, over a ring of slots."""
    return core.interval <= RING_SLOTS


def proof_texts(core: Core, depth: int, out_bits: int) -> Mapping[str, Any]:
    """Return what the templates of the proof take.

    Args:
        core: inside the stream.
        depth: places of the stream.
        out_bits: of the word in each of them.
    """
    count, place = depth.bit_length(), (depth - 1).bit_length()
    seen = [(name, count, f"stream.{name}") for name in ("credits", "level")]
    seen += [(name, place, f"stream.{name}") for name in ("entry", "tail", "head")]
    seen += [(name, 1, f"stream.{name}") for name in ("accepted", "made")]
    seen += [("shown", out_bits, "stream.shown")]
    seen += [("words", depth * out_bits, _places("words", depth)), ("lasts", depth, _places("lasts", depth))]
    valid_depth = -(-core.latency // core.interval)
    if valid_depth:
        seen.append(("core_valid", valid_depth, f"stream.core.{core.valid}"))
    if core.interval > 1:
        seen.append(("core_slot", core.interval, f"stream.core.{core.slot}"))
    return {"valid_depth": valid_depth, "seen_inside": seen, "not_yet_out": _not_yet_out(core, valid_depth)}


def _places(memory: str, depth: int) -> str:
    return ",".join(f"stream.{memory}[{place}]" for place in reversed(range(depth)))


def _not_yet_out(core: Core, valid_depth: int) -> str:
    """Return when the last valid bit is of a sample that has not left: it stays until the next slot 0."""
    last = f"core_valid[{valid_depth - 1}]"
    leaves = core.latency % core.interval
    if not leaves:
        return last
    return f"{last} && (core_slot[{leaves}:1] != {leaves}'d0)" if leaves > 1 else f"{last} && core_slot[1]"
