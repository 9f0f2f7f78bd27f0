"""What cells of circuits take of a clock period, by a small model of lookup tables and chains of carries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.arith.circuits.circuit import Gate, width_of

_FREE = frozenset(("input", "constant", "register", "shl", "shr", "low", "join", "narrow", "cut", "not"))
"""Cells that are wires, or that the lookup tables behind them take in."""


@dataclass(frozen=True, slots=True)
class Delays:
    """The delays of a device, in nanoseconds.

    Attributes:
        table_ns: a lookup table, with the way to it.
        chain_ns: an addition without its length, with the way to it.
        carry_ns: a place of a chain of carries.
        product_ns: a product of the size that the device has a multiplier for.
        register_ns: what a register takes of the period, from the clock and before it.
        product_bits: bits of both factors of such a multiplier.
    """

    table_ns: float = 1.1
    chain_ns: float = 1.9
    carry_ns: float = 0.04
    product_ns: float = 4.5
    register_ns: float = 0.8
    product_bits: int = 18


DELAYS = Delays()
"""Of a device with tables of four inputs; those of an ECP5, see `benchmarks/units_clock.py`."""


@dataclass(frozen=True, slots=True)
class Clocking:
    """A clock period in nanoseconds, infinite of a circuit without registers, and the delays of a device."""

    period_ns: float
    delays: Delays = DELAYS

    @property
    def free_ns(self) -> float:
        """What registers leave of the period."""
        return self.period_ns - self.delays.register_ns

    @property
    def entry_ns(self) -> float:
        """When inputs exist in their cycle: behind the multiplexers in front of a unit."""
        return self.delays.table_ns

    def delay_ns(self, kind: str, operands: Sequence[Gate], lo: int, hi: int) -> float:
        """Return the delay of a cell."""
        if kind in _FREE:
            return 0.0
        match kind:
            case "add" | "addc" | "sub" | "subc" | "round":
                return self._chain(width_of(lo, hi))
            case "addsub" | "negif":
                # Of a constant one all bits are those of the sign, perhaps inverted.
                plain = operands[0 if kind == "negif" else 1].kind == "constant"
                return self._chain(width_of(lo, hi)) + (0.0 if plain else self.delays.table_ns)
            case "eq":
                bits = max(each.width for each in operands) * (
                    2 - any(o.kind == "constant" for o in operands)
                )
                return self._tables(bits)
            case "pick":
                return self._tables(max(operands[0].width, 4))
            case "mul":
                return self._product(*(each.width for each in operands))
        # Gates of single bits are taken together: of two in a row about one has a table of its own.
        return self.delays.table_ns * (0.6 if lo >= 0 and hi <= 1 else 1.0)

    def _chain(self, bits: int) -> float:
        return self.delays.chain_ns + self.delays.carry_ns * bits

    def _tables(self, bits: int) -> float:
        """Return the delay of a function of many bits in lookup tables of 4."""
        return self.delays.table_ns * max(1, math.ceil(math.log(max(bits, 2), 4) - 1e-9))

    def _product(self, first: int, second: int) -> float:
        parts = math.prod(math.ceil(bits / self.delays.product_bits) for bits in (first, second))
        return self.delays.product_ns + (parts - 1).bit_length() * self._chain(first + second)


COMBINATIONAL = Clocking(math.inf)
"""No registers at all."""
