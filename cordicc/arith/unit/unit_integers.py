"""A unit in integers: all constants, shifts and widths that decide on its bits, as plain data for a plan.

Nothing is computed here: step tables, thresholds, quarter turns and places are those that the emulator, the C
model and the circuits work with.  `docs/units.md` says what hardware does with them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cordicc.arith.kernels.reduction import (
    LN2_BITS,
    PHASE_EXPONENTS,
    SCALE_BITS,
    TAU_BITS,
    TURN_TAIL_BITS,
    QuarterTurns,
    phase_constants,
)
from cordicc.arith.kernels.shift_sequences import (
    FACTOR_BITS,
    SHARES,
    StepTable,
    inverse_ln2_fixed,
    ln2_fixed,
    pi_fixed,
)
from cordicc.arith.kernels.thresholds import ROOT_SCALE, ROOTS, UPPER
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.slack import Rows, slack_of
from cordicc.arith.unit.arithmetic import Arithmetic, least_exponent
from cordicc.arith.unit.cau import (
    EXPONENT_BITS,
    INTEGER_BITS,
    Cau,
    implicit_steps,
    implicit_table,
    standard_table,
)
from cordicc.arith.unit.reach import ReachTable

_SYSTEMS = {1: "circular", 0: "linear", -1: "hyperbolic"}
_PI_BITS = 120
"""So many that pi to the bits that anything takes is this one rounded."""

_INVERSE_LN2_BITS = 30


def steps_name(op: str, params: Mapping[str, Any]) -> str:
    """Return the name of the iterations that an operation of a unit takes."""
    system = _SYSTEMS[-1 if op == "lightcone" else params["m"]]
    return f"implicit-{system}" if op == "implicit" else system


def iterations(unit: Cau) -> dict[str, StepTable]:
    """Return all iterations of a unit by name."""
    found = {name: standard_table(unit, m) for m, name in _SYSTEMS.items()}
    if unit.rule is not None:
        found |= {f"implicit-{_SYSTEMS[m]}": implicit_steps(unit, m) for m in (1, -1)}
    return found


def shared_data() -> dict[str, Any]:
    """Return the constants of all units."""
    return {
        "pi": _number(pi_fixed(_PI_BITS), _PI_BITS),
        "tau": _number(pi_fixed(TAU_BITS + 1), TAU_BITS),
        "ln2": _number(ln2_fixed(LN2_BITS), LN2_BITS),
        "inverse_ln2": _number(inverse_ln2_fixed(_INVERSE_LN2_BITS), _INVERSE_LN2_BITS),
        "gain_places": SCALE_BITS,
        "growth_fraction": FACTOR_BITS,
        "shares": SHARES,
        "upper": UPPER,
        "root_scale": ROOT_SCALE,
        "roots": list(ROOTS),
    }


def unit_data(unit: Cau, names: Iterable[str]) -> dict[str, Any]:
    """Return the widths of a unit and the iterations of some names.  Raises KeyError if it has not all."""
    half_turn = pi_fixed(unit.angle_bits)
    data: dict[str, Any] = {
        "operand_bits": unit.operand_bits,
        "fraction_bits": unit.fraction_bits,
        "integer_bits": INTEGER_BITS,
        "angle_bits": unit.angle_bits,
        "exponent_bits": EXPONENT_BITS,
        "half_turn": half_turn,
        "quarter_turn": (half_turn + 1) >> 1,
        "steps": {name: _steps(unit, name) for name in sorted(set(names))},
    }
    return data if unit.rule is None else {**data, "rule": unit.rule}


def _steps(unit: Cau, name: str) -> dict[str, Any]:
    table = iterations(unit)[name]
    data: dict[str, Any] = {
        "shifts": list(table.shifts),
        "angles": list(table.angles),
    }
    if table.m:  # linear iterations have no gain
        data["inverse_gain"] = _number(table.inverse_gain, table.coordinate_bits + 1)
    if not name.startswith("implicit-"):
        return data
    data["stretched"] = list(table.stretched)
    if unit.rule == "root-free":
        return {**data, "doubles": table.doubles, "unsettled": table.unsettled}
    return {**data, "target_factors": list(table.target_factors)}


def operation_data(
    arithmetic: Arithmetic, kind: str, op: str, settings: Mapping[str, Any], operands: Sequence[FixedPoint]
) -> dict[str, Any]:
    """Return what an operation of a unit holds besides: by its formats and its slack.

    Args:
        arithmetic: the arithmetic of the target, a fixed-point one.
        kind: of the unit.
        op: the operation.
        settings: its parameters, and its slack.
        operands: the formats of its operands.

    Raises:
        ValueError: units of the kind have no implicit mode.
    """
    unit = arithmetic.caus[kind]
    data: dict[str, Any] = {"steps": steps_name(op, settings)}
    if op == "implicit":
        reach = implicit_table(unit, settings["m"], slack_of(settings)).reach
        data["reach"] = _reach(reach, settings["m"])
    elif data["steps"] == "hyperbolic" and op != "rotate":
        rows, places = unit.root_slack(slack_of(settings))
        data["slack"] = {**_rows(rows), "places": places.tolist(), "relative": slack_of(settings).relative}
    elif data["steps"] == "circular" and op == "rotate":
        x, y, z = operands
        data["least_exponent"] = least_exponent(x, y, unit.operand_bits)
        quarters = arithmetic.quarters(kind, z)
        data |= {"turns": _turns(z, unit)} if quarters is None else {"quarters": _quarters(quarters)}
    return data


def _number(word: int, fraction: int) -> dict[str, Any]:
    """Return a constant; a JSON number holds 53 bits everywhere."""
    return {"word": word if abs(word) < 1 << 53 else str(word), "fraction": fraction}


def _rows(rows: Rows) -> dict[str, int]:
    return {"first": rows.first}


def _reach(table: ReachTable, m: int) -> dict[str, Any]:
    columns = {name: column.tolist() for name, column in table.columns._asdict().items()}
    if m > 0:
        del columns["beyond"]  # on the circle y may be as far beyond the target as it gets
    return {**_rows(table.rows), **columns}


def _quarters(table: QuarterTurns) -> dict[str, Any]:
    return {
        "fraction": table.fraction_bits,
        "thresholds": list(table.thresholds),
        "multiples": list(table.multiples),
    }


def _turns(angle: FixedPoint, unit: Cau) -> dict[str, Any]:
    """Return 2^e/(2 pi) modulo 1 for the exponents of normalised words of a format."""
    lowest = 1 - angle.fraction_bits - unit.operand_bits
    exponents = range(lowest, lowest + angle.width_bits - 1)
    heads, tails = phase_constants()
    at = [
        min(max(e, PHASE_EXPONENTS.start), PHASE_EXPONENTS.stop - 1) - PHASE_EXPONENTS.start
        for e in exponents
    ]
    words = [(int(heads[i]) << TURN_TAIL_BITS) + int(tails[i]) for i in at]
    return {"first": exponents.start, "tail": TURN_TAIL_BITS, "words": [str(word) for word in words]}
