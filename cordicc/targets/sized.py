"""What a fixed-point target leaves open, filled in: guard bits, and the sizes of its CORDIC units.

A target says `auto` where a figure follows from others.  Guard bits are the compiler's choice; given them,
`cordicc.arith.unit.sizing` sizes each unit so that its proven error stays within 1 ulp of a word between
operations, for the functions that it is used for, and latency, adders and area follow.  `clocked` is a
latency that the unit's circuit takes at the clock of the target, on its device.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence, Set
from functools import cache, partial
from typing import Any

from cordicc.arith.circuits.cell_delays import Clocking
from cordicc.arith.circuits.unit_cycles import cycles_at
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.arith.unit.cau import EXPONENT_BITS, INTEGER_BITS, Cau
from cordicc.arith.unit.sizing import size_unit
from cordicc.targets.device import DEVICES
from cordicc.targets.target import CAU_KINDS, FUNCTIONS_OF_KIND

AUTO = "auto"
ITERATIONS = "iterations"
"""Of the interval of a unit that makes its iterations one after the other."""

CLOCKED = "clocked"
"""Of a latency that follows from the clock and the device."""

_MOST_GUARD_BITS = 6
WIDEST_WORD_BITS = 30
"""The widest words for which a bound of every unit, implicit ones included, fits 64-bit emulation."""

_LONGEST_INTERVAL = 100_000

_REFERENCE_BITS = 32
"""Of the adder that counts as 1 in a figure of area."""

_MOST_ADDERS = 100_000
"""Of a figure in the file; what is beyond stays, and is told as not being a number of adders."""

WEIGHTS = ("adder_bit", "dsp", "ram_bit")
"""Look-up tables that count for a bit of an adder, a multiplier block, a bit of block RAM."""

Data = dict[Any, Any]


def most_guard_bits(width_bits: int) -> int:
    """Return the most guard bits that are worth a trial with words of a width."""
    return max(0, min(_MOST_GUARD_BITS, WIDEST_WORD_BITS - width_bits))


def guard_is_open(data: Mapping[Any, Any]) -> bool:
    """Tell whether a target's data leaves the guard bits to the compiler."""
    format_ = data.get("format")
    return isinstance(format_, dict) and format_.get("guard") == AUTO


def sized(
    data: Data,
    guard_bits: int,
    width_bits: int | None = None,
    used: Set[str] | None = None,
    *,
    alone: bool = False,
) -> Data:
    """Return a target's data with everything filled in that it leaves open.

    Args:
        data: the mapping of a target file, perhaps malformed: what is not understood stays.
        guard_bits: in the place of `guard: auto`.
        width_bits: in the place of the width, where the guard bits are left open.
        used: functions that are asked of the units, None of all; a unit that does none of them has them all.
        alone: whether a unit does one function each, and has the latency of that.

    Raises:
        ValueError: no unit keeps the error with so many bits.
    """
    format_ = data.get("format")
    units = data.get("units")
    if not isinstance(format_, dict) or format_.get("kind") != "fixed-point" or not isinstance(units, dict):
        return data
    if format_.get("guard") == AUTO:
        format_ = {**format_, "guard": guard_bits, "width": width_bits or format_.get("width")}
    width, guard = format_.get("width"), format_.get("guard", 0)
    if type(width) is not int or type(guard) is not int:
        return {**data, "format": format_}
    made = {}
    for kind, unit in units.items():
        made[kind] = unit
        if isinstance(unit, dict):
            filled = _sized_unit(unit, width + guard, used, weighed="weights" in data)
            filled = _with_latency(str(kind), filled, {**data, "format": format_}, used, alone=alone)
            made[kind] = _with_area(kind, filled, width + guard, data)
    return {**data, "format": format_, "units": made}


def _sized_unit(unit: Data, word_bits: int, used: Set[str] | None, *, weighed: bool) -> Data:
    stages, arithmetic = unit.get("stages", {}), unit.get("arithmetic")
    functions = unit.get("functions")
    open_arithmetic = arithmetic == AUTO or (isinstance(arithmetic, dict) and set(arithmetic) == {"rule"})
    if not open_arithmetic or not isinstance(stages, dict) or not isinstance(functions, list):
        return unit
    rule = arithmetic["rule"] if isinstance(arithmetic, dict) else None
    names = [str(function) for function in functions]
    needed = _needed(names, used)
    cau = _cau(tuple(needed), word_bits, None if rule is None else str(rule))
    made: Data = {**unit, "arithmetic": _arithmetic(cau)}
    if stages:
        made["stages"] = {
            part: cau.iterations if cycles == AUTO else cycles
            for part, stated in stages.items()
            for cycles in _cycles(stated, names, needed)
        }
    if unit.get("initiation_interval") == ITERATIONS:
        made["initiation_interval"] = cau.iterations
    if unit.get("latency") == AUTO and stages and all(type(c) is int for c in made["stages"].values()):
        made["latency"] = sum(made["stages"].values())
    adders = unit.get("adders")
    counts = adders.values() if isinstance(adders, dict) else ()
    if (
        isinstance(adders, dict)
        and set(adders) == {"around", "per_iteration"}
        and all(type(count) is int and 0 <= count <= _MOST_ADDERS for count in counts)
    ):
        made["adders"] = adders["around"] + adders["per_iteration"] * cau.iterations
        if unit.get("area") == AUTO and not weighed:
            bits = cau.fraction_bits + INTEGER_BITS
            made["area"] = round(made["adders"] * bits / _REFERENCE_BITS, 1)
    return made


def _cycles(stated: Any, known: Sequence[str], needed: Sequence[str]) -> list[Any]:
    """Return the cycles of a part in a list, which is empty if only functions not needed go through it."""
    if isinstance(stated, dict) and set(stated) == {"cycles", "functions"}:
        through = stated["functions"]
        if isinstance(through, list) and through and all(name in known for name in through):
            return [stated["cycles"]] if any(name in needed for name in through) else []
    return [stated]


def _needed(names: Sequence[str], used: Set[str] | None) -> list[str]:
    """Return the functions that are asked of a unit; of one that does none of them all."""
    return [name for name in names if used is None or name in used] or list(names)


def _with_latency(kind: str, unit: Data, data: Data, used: Set[str] | None, *, alone: bool) -> Data:
    """Return a unit with the latency of its circuit, where that is open and the target has a device."""
    device, functions, clock_hz = (
        DEVICES.get(str(data.get("device"))),
        unit.get("functions"),
        data.get("clock_hz"),
    )
    if unit.get("latency") != CLOCKED or device is None or not isinstance(functions, list):
        return unit
    if isinstance(clock_hz, bool) or not isinstance(clock_hz, (int, float)) or clock_hz < 1:
        return unit
    names = [str(function) for function in functions]
    if not all(name in FUNCTIONS_OF_KIND.get(kind, ()) for name in names):
        return unit
    needed = _needed(names, used)
    interval = unit.get("initiation_interval", 1)
    if type(interval) is not int or not 1 <= interval <= _LONGEST_INTERVAL:
        return unit
    try:
        units = {kind: unit["arithmetic"]} if kind in CAU_KINDS else {}
        clocked = partial(
            _clocked,
            json.dumps({"format": data["format"], "units": units}),
            kind,
            clocking=Clocking(1e9 / clock_hz, device.delays),
            interval=interval,
        )
        if not alone:
            return {**unit, "latency": clocked(tuple(needed))}
        latencies = {function: clocked((function,)) for function in needed}
    except (TypeError, KeyError):
        return unit
    return {**unit, "latency": max(latencies.values()), "latencies": latencies}


@cache
def _clocked(
    arithmetic: str, kind: str, functions: tuple[str, ...], clocking: Clocking, interval: int
) -> int:
    return cycles_at(Arithmetic.from_spec(json.loads(arithmetic)), kind, functions, clocking, interval)


def _with_area(kind: object, unit: Data, word_bits: int, data: Data) -> Data:
    """Return a unit with its area in look-up tables, where that is open and the target has weights."""
    weights, adders, arithmetic = data.get("weights"), unit.get("adders"), unit.get("arithmetic")
    if unit.get("area") != AUTO or not isinstance(weights, dict) or type(adders) is not int:
        return unit
    per_bit, per_dsp = weights.get("adder_bit"), weights.get("dsp")
    if not isinstance(per_bit, (int, float)) or not isinstance(per_dsp, (int, float)):
        return unit
    bits = arithmetic["mantissa_bits"] if isinstance(arithmetic, dict) else word_bits
    device = DEVICES.get(str(data.get("device")))
    blocks = 0
    if kind == "mul" and device is not None and device.dsp_bits is not None:
        blocks = math.prod(-(-word_bits // (each - 1)) for each in device.dsp_bits)
    return {**unit, "area": round(adders * bits * per_bit + blocks * per_dsp, 1)}


@cache
def _cau(functions: tuple[str, ...], word_bits: int, rule: str | None) -> Cau:
    return size_unit(functions, word_bits, rule=rule).unit


def _arithmetic(cau: Cau) -> Data:
    widths = {
        "mantissa_bits": cau.fraction_bits + INTEGER_BITS,
        "exponent_bits": EXPONENT_BITS,
        "angle_bits": cau.angle_bits,
        "iterations": cau.iterations,
    }
    return widths if cau.rule is None else {**widths, "rule": cau.rule}
