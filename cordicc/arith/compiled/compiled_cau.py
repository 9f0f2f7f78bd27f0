"""A unit whose operations are compiled by numba, with the bits of `cordicc.arith.unit.cau`.

numba is optional (`cordicc[fast]`).  Importing it and loading machine code takes about a second, compiling
at the very first use some ten, so only long runs want it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from cordicc.arith.compiled.compiled_systems import compiled_system
from cordicc.arith.kernels.blocks import ZERO_EXPONENT
from cordicc.arith.kernels.micro_rotations import limbs
from cordicc.arith.kernels.reduction import SCALE_BITS, TAU_BITS, QuarterTurns, phase_constants
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, StepTable, pi_fixed
from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.arith.unit.cau import Cau, implicit_table, standard_table
from cordicc.base.arrays import Floats

_BRANCHES = {"+": 1, "-": -1, "none": 0}


def available() -> bool:
    """Tell whether numba is installed."""
    return find_spec("numba") is not None


def is_compiled(arithmetic: Arithmetic) -> bool:
    """Tell whether an arithmetic has compiled units already."""
    return any(isinstance(cau, CompiledCau) for cau in arithmetic.caus.values())


def compiled_arithmetic(arithmetic: Arithmetic) -> Arithmetic:
    """Return an arithmetic with the same bits whose units are compiled; needs numba."""
    units = {
        kind: CompiledCau(**{field.name: getattr(cau, field.name) for field in fields(Cau)})
        for kind, cau in arithmetic.caus.items()
    }
    return replace(arithmetic, system=compiled_system(arithmetic.system), caus=units)


@dataclass(frozen=True, slots=True)
class CompiledCau(Cau):
    """A unit with the operations of `Cau`, compiled."""

    def rotate(
        self,
        m: int,
        x: Floats,
        y: Floats,
        z: Floats,
        *,
        quarters: QuarterTurns | None = None,
        least: int = ZERO_EXPONENT,
    ) -> tuple[Floats, Floats]:
        """Turn (x, y) by z, as `Cau.rotate` does."""
        from cordicc.arith.compiled import unit_loops as units

        constants = _steps(standard_table(self, m))
        if m == 1:
            reduction = _reduction(self.angle_bits), _quarters(quarters)
            return self._run(units.rotate_circular, (x, y, z), constants, *reduction, least)
        return self._run(units.rotate_linear if m == 0 else units.rotate_hyperbolic, (x, y, z), constants)

    def vector(
        self, m: int, sign: int, x: Floats, y: Floats, z: Floats, *, slack: Slack = EXACT
    ) -> tuple[Floats, Floats]:
        """Return norm and angle, as `Cau.vector` does."""
        from cordicc.arith.compiled import implicit_loops, unit_loops

        constants = _steps(standard_table(self, m))
        if m == 1:
            half_turn = pi_fixed(self.angle_bits)
            return self._run(unit_loops.vector_circular, (x, y, z), constants, sign, half_turn)
        if m == 0:
            return self._run(unit_loops.vector_linear, (x, y, z), constants, sign)
        return self._run(implicit_loops.lightcone, (x, y, z), constants, sign, self._margin(slack))

    def lightcone(self, u: Floats, v: Floats, *, slack: Slack = EXACT) -> tuple[Floats, Floats]:
        """Return sqrt(u v) and ln(u/v)/2, as `Cau.lightcone` does."""
        from cordicc.arith.compiled.implicit_loops import lightcone

        return self._run(lightcone, (u, v, v), _steps(standard_table(self, -1)), 0, self._margin(slack))

    def _margin(self, slack: Slack) -> tuple[Any, ...]:
        """Return the slack in the form of `implicit_loops.Margin`."""
        rows, places = self.root_slack(slack)
        return rows.first, places, int(slack.relative)

    def implicit(
        self, m: int, branch: str, A: Floats, B: Floats, C: Floats, *, slack: Slack = EXACT
    ) -> tuple[Floats, Floats]:
        """Solve B cos t + A sin t = C, as `Cau.implicit` does."""
        from cordicc.arith.compiled import implicit_loops

        if self.rule is None:
            raise ValueError("this unit has no implicit mode")
        table = implicit_table(self, m, slack)
        function = implicit_loops.implicit_circular if m == 1 else implicit_loops.implicit_hyperbolic
        rule = (int(not table.quarter_turns), pi_fixed(self.angle_bits), _BRANCHES[branch])
        reach = (table.reach.rows.first, *table.reach.columns)
        return self._run(function, (A, B, C), _steps(table.steps), rule, reach)

    def _run(
        self, function: Callable[..., None], operands: tuple[Floats, ...], *constants: Any
    ) -> tuple[Floats, Floats]:
        arrays = [np.atleast_1d(np.asarray(operand, dtype=np.float64)) for operand in operands]
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
        flat = [np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1) for array in arrays]
        first, second = np.empty(flat[0].size), np.empty(flat[0].size)
        widths = (self.operand_bits, self.fraction_bits, self.angle_bits)
        function(*flat, first, second, widths, *constants)
        return first.reshape(shape), second.reshape(shape)


@cache
def _steps(table: StepTable) -> tuple[Any, ...]:
    """Return the constants of iterations in the form of `step_loops.Steps`."""
    bits = table.coordinate_bits
    factors = [(factor, *_limbs(factor, FACTOR_BITS, bits)) for factor in table.target_factors]
    columns = np.array(factors, dtype=np.int64).reshape(-1, 3).T
    shift = bits + 1 - SCALE_BITS
    gain = (table.inverse_gain, shift, *_limbs(table.inverse_gain, shift, bits))
    shifts, angles = np.array(table.shifts, dtype=np.int64), np.array(table.angles, dtype=np.int64)
    stretched = np.array(table.stretched, dtype=np.int64)
    turns = (table.doubles, table.unsettled)
    return shifts, angles, *(column.copy() for column in columns), gain, stretched, turns


@cache
def _reduction(angle_bits: int) -> tuple[Any, ...]:
    """Return the constants of the circular reduction in the form of `unit_loops.Reduction`."""
    heads, tails = phase_constants()
    shift = TAU_BITS + 3
    tau = pi_fixed(TAU_BITS + 1)
    return heads.view(np.int64), tails, (tau, shift, *_limbs(tau, shift, angle_bits))


@cache
def _quarters(quarters: QuarterTurns | None) -> tuple[Any, ...]:
    """Return a table of quarter turns, or none, in the form of `unit_loops.Quarters`."""
    if quarters is None:
        return -1, np.empty(0, np.int64), np.empty(0, np.int64)
    columns = (np.array(each, dtype=np.int64) for each in (quarters.thresholds, quarters.multiples))
    return quarters.fraction_bits, *columns


def _limbs(constant: int, shift: int, value_bits: int) -> tuple[int, int]:
    """Return the limbs of a product, -1 of them where its quotient rounds to 0."""
    if value_bits + constant.bit_length() < shift:
        return -1, 0
    return limbs(constant, shift, value_bits)
