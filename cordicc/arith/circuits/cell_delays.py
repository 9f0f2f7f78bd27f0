"""What cells of circuits take of a clock period, by a small model of lookup tables and chains of carries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.arith.circuits.circuit import Gate, width_of

_FREE = frozenset(("input", "constant", "register", "shl", "shr", "low", "join", "narrow", "cut", "not"))
"""Cells that are wires, or that the lookup tables behind them take in."""


@dataclass(frozen=True, slots=True)
class Clocking:
    """A clock, and the delays of the device whose registers it drives.

    Attributes:
        period_ns: of the clock, less what registers take of it; infinite of a circuit without registers.
        table_ns: a lookup table, with the way to it.
        chain_ns: an addition without its length, with the way to it.
        carry_ns: a place of a chain of carries.
        product_ns: a product of the size that the device has a multiplier for.
        product_bits: bits of both factors of such a multiplier.
        entry_ns: when inputs exist in their cycle.
    """

    period_ns: float
    table_ns: float = 1.1
    chain_ns: float = 1.9
    carry_ns: float = 0.04
    product_ns: float = 4.5
    product_bits: int = 18
    entry_ns: float = 1.1

    def delay_ns(self, kind: str, operands: Sequence[Gate], lo: int, hi: int) -> float:
        """Return the delay of a cell."""
        if kind in _FREE:
            return 0.0
        match kind:
            case "add" | "addc" | "sub" | "round":
                return self._chain(width_of(lo, hi))
            case "addsub" | "negif":
                # Of a constant one all bits are those of the sign, perhaps inverted.
                plain = operands[-1 if kind == "negif" else 1].kind == "constant"
                plain = plain or (kind == "addsub" and operands[2].kind == "constant")
                return self._chain(width_of(lo, hi)) + (0.0 if plain else self.table_ns)
            case "lt":
                return self._chain(max(each.width for each in operands))
            case "eq":
                bits = max(each.width for each in operands) * (
                    2 - any(o.kind == "constant" for o in operands)
                )
                return self._tables(bits)
            case "pick":
                return self._tables(max(operands[0].width, 4))
            case "mul":
                return self._product(*(each.width for each in operands))
        return self.table_ns

    def _chain(self, bits: int) -> float:
        return self.chain_ns + self.carry_ns * bits

    def _tables(self, bits: int) -> float:
        """Return the delay of a function of many bits in lookup tables of 4."""
        return self.table_ns * max(1, math.ceil(math.log(max(bits, 2), 4) - 1e-9))

    def _product(self, first: int, second: int) -> float:
        parts = math.ceil(first / self.product_bits) * math.ceil(second / self.product_bits)
        return self.product_ns + (parts - 1).bit_length() * self._chain(first + second)


COMBINATIONAL = Clocking(math.inf)
"""No registers at all."""
