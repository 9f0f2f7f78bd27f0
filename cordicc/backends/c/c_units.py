"""CORDIC units in the C model: their tables, and their operations as functions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cordicc.arith.kernels.micro_rotations import NEVER, limbs
from cordicc.arith.kernels.reduction import (
    PHASE_EXPONENTS,
    SCALE_BITS,
    TAU_BITS,
    phase_constants,
)
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, StepTable, inverse_ln2_fixed, pi_fixed
from cordicc.arith.kernels.thresholds import SHARE_BITS, UPPER
from cordicc.arith.numbers.slack import Slack
from cordicc.arith.unit.cau import Cau, implicit_table
from cordicc.arith.unit.unit_integers import iterations
from cordicc.backends.c.c_sections import int64
from cordicc.targets.target import SYSTEMS


@dataclass(frozen=True, slots=True)
class ConstantProduct:
    """value * constant / 2^shift rounded half up; the lower limbs of the value, and their width in bits."""

    constant: int
    shift: int
    limbs: int
    bits: int


def product(constant: int, shift: int, value_bits: int) -> ConstantProduct:
    """Return the product with a constant, split so that it fits values of `value_bits` bits."""
    return ConstantProduct(constant, shift, *limbs(constant, shift, value_bits))


@dataclass(frozen=True, slots=True)
class Growth:
    """Iterations, from `start` on, in which the target grows by f/2^`shift` of itself, or not at all.

    `limbs` are those of the first factor, the largest: how many lower ones, and their bits.
    """

    start: int
    factors: tuple[int, ...]
    limbs: tuple[int, int] | None
    shift: int = FACTOR_BITS


@dataclass(frozen=True, slots=True)
class Steps:
    """A table of iterations: angle and shift of each, growth of the target, 1/gain."""

    table: StepTable

    @property
    def angles(self) -> tuple[int, ...]:
        """The angles."""
        return self.table.angles

    @property
    def steps(self) -> list[tuple[int, int]]:
        """Angle and shift of each iteration."""
        return list(zip(self.table.angles, self.table.shifts, strict=True))

    @property
    def inverse_gain(self) -> ConstantProduct:
        """The product that divides a coordinate by the gain, with four more bits."""
        bits = self.table.coordinate_bits
        constant = self.table.inverse_gain
        return product(constant, bits + 1 - SCALE_BITS, bits)

    @property
    def growth(self) -> list[Growth]:
        """How the target grows in each iteration, by stretches with an equal number of limbs.

        Later factors are smaller and need fewer limbs, the last do not move `coordinate_bits` bits: None.
        """
        bits, factors = self.table.coordinate_bits, self.table.target_factors
        found: list[Growth] = []
        for at, factor in enumerate(factors):
            seen = factor.bit_length() + bits >= FACTOR_BITS
            own = limbs(factor, FACTOR_BITS, bits) if seen else None
            if found and (own and own[0]) == (found[-1].limbs and found[-1].limbs[0]):
                found[-1] = Growth(found[-1].start, (*found[-1].factors, factor), found[-1].limbs)
            else:
                found.append(Growth(at, (factor,), own))
        return found


def unit_context(cau: Cau, prefix: str) -> dict[str, Any]:
    """Return what the template of a unit's functions needs."""
    quarter = pi_fixed(TAU_BITS + 1)
    return {
        "u": prefix,
        "rule": cau.rule,
        "F": cau.fraction_bits,
        "A": cau.angle_bits,
        "OB": cau.operand_bits,
        "steps": {name.replace("-", "_"): Steps(table) for name, table in iterations(cau).items()},
        "never": NEVER,
        "upper": UPPER,
        "share_bits": SHARE_BITS,
        "pi": pi_fixed(cau.angle_bits),
        "to_16_bits": _to_16_bits("angle", cau.angle_bits),
        "inverse_ln2": inverse_ln2_fixed(30),
        "quarter": product(quarter, TAU_BITS + 3, cau.angle_bits),
    }


def _to_16_bits(angle: str, bits: int) -> str:
    """Return an angle with so many fraction bits as one with 16."""
    return f"shift_down({angle}, {bits - 16})" if bits >= 16 else f"{angle} * {int64(1 << (16 - bits))}"


def phase_table(exponents: Sequence[range]) -> dict[str, Any]:
    """Return 2^e/(2 pi) modulo 1 for all the exponents: 64 fraction bits, and the 30 after them."""
    first = min((some.start for some in exponents), default=0)
    last = max((some.stop for some in exponents), default=0)
    assert PHASE_EXPONENTS.start <= first
    assert last <= PHASE_EXPONENTS.stop
    heads, tails = phase_constants()
    at = slice(first - PHASE_EXPONENTS.start, last - PHASE_EXPONENTS.start)
    return {"first": first, "turns": list(zip(heads[at].tolist(), tails[at].tolist(), strict=True))}


def function(op: str, params: Mapping[str, Any]) -> tuple[str, list[str]]:
    """Return the section of a unit operation and the arguments that follow its operands."""
    system = SYSTEMS.get(params.get("m", 1), "")
    if op == "vector":
        return f"vector_{system}", [str(params["sign"])]
    if op == "implicit":
        branch = {"+": 1, "-": -1, "none": 0}[params["branch"]]
        return f"solve_{system}", [str(branch if params["m"] == -1 else int(branch > 0))]
    return (op if op == "lightcone" else f"{op}_{system}"), []


@dataclass(frozen=True, slots=True)
class SlackTable:
    """A table that a call takes, as a declaration, and the arguments that hand it over."""

    declaration: str
    arguments: tuple[str, ...]


def slack_table(op: str, params: Mapping[str, Any], slack: Slack, cau: Cau, name: str) -> SlackTable | None:
    """Return what an operation holds of its slack, None if its domain has no border."""
    if op == "implicit":
        reach = implicit_table(cau, params["m"], slack).reach
        columns = (column.tolist() for column in reach.columns)
        rows = ", ".join(f"{{{_listed(row)}}}" for row in zip(*columns, strict=True))
        declaration = f"static const reach {name}[] = {{{rows}}};"
        return SlackTable(declaration, (name, str(reach.rows.first), str(reach.rows.count - 1)))
    if op == "lightcone" or (op == "vector" and params["m"] == -1):
        exponents, places = cau.root_slack(slack)
        declaration = f"static const int64_t {name}[] = {{{_listed(places.tolist())}}};"
        ends = (str(exponents.first), str(exponents.count - 1), str(int(slack.relative)))
        return SlackTable(declaration, (name, *ends))
    return None


def _listed(numbers: Iterable[int]) -> str:
    return ", ".join(int64(number) for number in numbers)
