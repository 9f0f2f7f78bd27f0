"""The circuit of a unit of a plan, for the operations that are bound to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.cell_delays import COMBINATIONAL, DELAYS, Clocking, Delays
from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.holding import held
from cordicc.arith.circuits.looping import too_fast
from cordicc.arith.circuits.plain_operations import ExactNumber, calculated, rounded
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.solving import implicit_unit
from cordicc.arith.circuits.standard import standard_unit
from cordicc.arith.circuits.uses import Use
from cordicc.arith.circuits.words import WordResult
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.unit.arithmetic import Arithmetic

PORTS = ("a", "b", "c")
RESULTS = ("first", "second")

_PERIODS = [1.05**number for number in range(201)]
"""Clock periods in ns that are tried: as short as nothing fits, and long enough for any unit in a cycle."""
_SLOWEST = len(_PERIODS) - 1


def constant_of(use: Use | Plain, at: int) -> int | None:
    """Return the word at a port that takes a constant, 0 of a port without an operand, else None."""
    if at >= len(use.operands):
        return 0
    return use.constants[at] if use.constants else None


@dataclass(frozen=True, slots=True)
class Plain:
    """An operation of an adder, a multiplier or sign logic, with its parameters and formats."""

    op: str
    params: tuple[tuple[str, Any], ...]
    operands: tuple[FixedPoint, ...]
    result: FixedPoint
    constants: tuple[int | None, ...] = ()

    def delivered(self, number: int) -> FixedPoint | None:
        """Return the format of a result by its number."""
        return self.result if number == 0 else None

    @property
    def settings(self) -> Mapping[str, Any]:
        """The parameters by name."""
        return dict(self.params)


def unit_circuit(
    name: str,
    arithmetic: Arithmetic,
    kind: str,
    uses: Sequence[Use | Plain],
    latency: int,
    delays: Delays = DELAYS,
    interval: int = 1,
) -> Circuit:
    """Return the circuit of a unit with some latency in cycles, for as fast a clock as that allows.

    It takes an operation every `interval` cycles.  A standard unit makes its steps one after the other if
    these are no more; any unit has one register where a number waits.

    Inputs are `ok`, which tells that all operands stand for numbers; `mode`, the number of the use, if there
    are several; and `a`, `b`, `c`, words in two's complement of the widest operand that stands there, but for
    those that are constant in every use.
    Outputs are `first` and `second`, and with `_ok` behind the name whether they stand for numbers.

    Raises:
        NoCircuitError: a use has none.
    """
    if not latency:
        return unit_builder(name, arithmetic, kind, uses, COMBINATIONAL).circuit(0)
    fits, fails = _SLOWEST, 0
    best = unit_builder(name, arithmetic, kind, uses, Clocking(_PERIODS[fits], delays), interval)
    while fits - fails > 1:
        middle = (fits + fails) // 2
        made = unit_builder(name, arithmetic, kind, uses, Clocking(_PERIODS[middle], delays), interval)
        if made.cycles() <= latency and not too_fast(made):
            fits, best = middle, made
        else:
            fails = middle
    return held(best.circuit(latency), interval)


def unit_builder(
    name: str,
    arithmetic: Arithmetic,
    kind: str,
    uses: Sequence[Use | Plain],
    clocking: Clocking,
    interval: int = 1,
) -> CircuitBuilder:
    """Return the circuit of a unit before its latency is stated, pipelined for a clock; see `unit_circuit`.

    Raises:
        NoCircuitError: a use has none.
    """
    b = CircuitBuilder(name, clocking, interval)
    ports = max(len(use.operands) for use in uses)
    widths = [
        max(use.operands[at].width_bits for use in uses if at < len(use.operands)) for at in range(ports)
    ]
    ok = b.input("ok", 0, 1)
    mode = b.input("mode", 0, len(uses) - 1) if len(uses) > 1 else b.of(0)
    operands = tuple(
        b.pick(mode, [word or 0 for word in words])
        if None not in (words := [constant_of(use, at) for use in uses])
        else b.word(port, width)
        for at, (port, width) in enumerate(zip(PORTS, widths, strict=False))
    )
    results: Sequence[WordResult | None]
    if kind in arithmetic.caus:
        cordic = tuple(use for use in uses if isinstance(use, Use))
        make = standard_unit if kind == "standard" else implicit_unit
        results = make(b, arithmetic.caus[kind], cordic, operands, mode)
    else:
        plain = tuple(use for use in uses if isinstance(use, Plain))
        assert isinstance(arithmetic.system, FixedSystem)
        results = [_plain(b, arithmetic.system, plain, operands, mode)]
    for number, (port, result) in enumerate(zip(RESULTS, results, strict=False)):
        if result is not None:
            width = max(f.width_bits for use in uses if (f := use.delivered(number)) is not None)
            b.output(port, b.as_word(result.word, width))
            b.output(f"{port}_ok", result.valid & ok)
    return b


def _plain(
    b: CircuitBuilder,
    system: FixedSystem,
    uses: tuple[Plain, ...],
    words: tuple[CircuitSignal, ...],
    mode: CircuitSignal,
) -> WordResult:
    if uses[0].op in ("mul", "cmul"):
        return _product(b, system, uses, words, mode)
    results = []
    for use in uses:
        numbers = [
            ExactNumber(word, f.fraction_bits, f.width_bits)
            for word, f in zip(words, use.operands, strict=False)
        ]
        results.append(calculated(b, use.op, use.settings, numbers, use.result))
    return _of_mode(b, mode, results)


def _product(
    b: CircuitBuilder,
    system: FixedSystem,
    uses: tuple[Plain, ...],
    words: tuple[CircuitSignal, ...],
    mode: CircuitSignal,
) -> WordResult:
    """Return a product: one multiplier for all uses, of one constant factor its digits."""
    factors = []
    for use in uses:
        if use.op == "cmul":
            factor, format_ = system.constant(use.settings["factor"])
            assert isinstance(format_, FixedPoint)
            factors.append((int(factor), format_.fraction_bits))
    if factors and len({word for word, _ in factors}) == 1:
        word = factors[0][0]
        exact = times(b, words[0], abs(word)) if word else b.of(0)
        exact = -exact if word < 0 else exact
    else:
        second = b.pick(mode, [word for word, _ in factors]) if factors else words[1]
        exact = b.named("product", words[0] * second)
    results = []
    for number, use in enumerate(uses):
        other = factors[number][1] if factors else use.operands[1].fraction_bits
        results.append(rounded(b, ExactNumber(exact, use.operands[0].fraction_bits + other), use.result))
    return _of_mode(b, mode, results)


def _of_mode(b: CircuitBuilder, mode: CircuitSignal, results: Sequence[WordResult]) -> WordResult:
    """Return the result with the number of the mode."""
    found = results[0]
    for number, own in enumerate(results[1:], 1):
        chosen = mode.equals(number)
        found = WordResult(b.mux(chosen, found.word, own.word), b.mux(chosen, found.valid, own.valid))
    return found
