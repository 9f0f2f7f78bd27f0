"""Circuits of units have the bits of the units, for all words of small formats or many of large ones."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cordicc.arith.circuits.builder import CircuitBuilder
from cordicc.arith.circuits.evaluation import outputs_of
from cordicc.arith.circuits.shifting import digits_of, length_of, times
from cordicc.arith.circuits.units import unit_circuit
from cordicc.arith.circuits.uses import Use
from cordicc.arith.kernels.reduction import quarter_turns
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.arith.unit.arithmetic import least_exponent
from cordicc.arith.unit.cau import Cau
from cordicc.arith.unit.sizing import size_unit
from tests.support.selection import quick

WIDTH = 9
LATENCY = 60
STANDARD = {
    "vector_circular": ("vector", 1),
    "rotate_circular": ("rotate", 1),
    "vector_linear": ("vector", 0),
    "rotate_linear": ("rotate", 0),
    "vector_hyperbolic": ("vector", -1),
    "rotate_hyperbolic": ("rotate", -1),
    "lightcone": ("lightcone", -1),
}
FUNCTIONS = (
    "rotate-circular",
    "rotate-linear",
    "rotate-hyperbolic",
    "vector-circular",
    "vector-linear",
    "vector-hyperbolic",
    "lightcone",
)
FRACTIONS = [(6, 6, 6, 5, 6), (5, 7, 6, 6, 5)]
SLACK = Slack(2.0**-5, 2.0**-6)


def use_of(op: str, m: int, fractions: tuple[int, ...], **more: Any) -> Use:
    a, b, c, first, second = (FixedPoint(WIDTH, fraction) for fraction in fractions)
    operands = (a, b) if op == "lightcone" else (a, b, c)
    angle = {"vector": 1, "implicit": 0}.get(op) if m == 1 else None
    return Use(op, m, operands, (first, second), angle=angle, **more)


def words_of(use: Use, count: int, seed: int) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    top = use.operands[0].largest_word
    drawn = random.integers(-top, top + 1, (3, count)) >> random.integers(0, WIDTH - 2, (3, count))
    drawn[0, : count // 8] = 0
    drawn[1, count // 16 : count // 6] = 0
    if use.op == "implicit":
        # NearColumns the end of reach.
        a, b, c = (format_.fraction_bits for format_ in use.operands)
        square = (drawn[1] * 2.0**-b) ** 2 + use.m * (drawn[0] * 2.0**-a) ** 2
        near = np.round(np.sqrt(np.maximum(square, 0)) * 2.0**c) + random.integers(-1, 2, count)
        near = np.clip(near * random.choice([-1, 1], count), -top, top).astype(np.int64)
        drawn[2] = np.where(random.random(count) < 0.3, near, drawn[2])
    return list(drawn[: len(use.operands)])


def expected(unit: Cau, use: Use, words: list[np.ndarray]) -> list[np.ndarray]:
    values = [format_.decode(word) for format_, word in zip(use.operands, words, strict=True)]
    match use.op:
        case "rotate":
            angle = use.operands[2]
            quarters = quarter_turns(unit.angle_bits, angle.width_bits, angle.fraction_bits)
            least = least_exponent(*use.operands[:2], unit.operand_bits)
            made = unit.rotate(use.m, *values, quarters=quarters, least=least)
        case "vector":
            made = unit.vector(use.m, use.sign, *values, slack=use.slack)
        case "lightcone":
            made = unit.lightcone(*values, slack=use.slack)
        case _:
            made = unit.implicit(use.m, use.branch, *values, slack=use.slack)
    found = []
    for number, (value, format_) in enumerate(zip(made, use.results, strict=True)):
        assert format_ is not None
        found.append(format_.encode_angle(value) if use.angle == number else format_.encode(value))
    return found


def check(kind: str, unit: Cau, uses: list[Use], count: int = 4_000, interval: int = 1) -> None:
    arithmetic: Any = SimpleNamespace(caus={kind: unit}, system=None)
    circuit = unit_circuit("unit", arithmetic, kind, uses, LATENCY, interval=interval)
    assert circuit.latency == LATENCY
    assert bool(circuit.loops) == (interval > 1)
    for mode, use in enumerate(uses):
        words = words_of(use, count, mode)
        given = dict(zip("abc", words, strict=False)) | {"ok": np.ones(count), "mode": np.full(count, mode)}
        inputs = {port.name: given.get(port.name, np.zeros(count)) for port in circuit.inputs}
        found = outputs_of(circuit, inputs)
        for name, word in zip(("first", "second"), expected(unit, use, words), strict=True):
            invalid = -(1 << (WIDTH - 1))
            delivered = np.where(found[f"{name}_ok"] == 1, found[name], invalid)
            assert np.array_equal(delivered, word), (use.function, name)


@pytest.mark.parametrize("name", quick(STANDARD, "vector_circular", "rotate_circular", "lightcone"))
@pytest.mark.parametrize("binary_points", quick([0, 1], 1))
def test_a_standard_unit(name: str, binary_points: int) -> None:
    fractions = FRACTIONS[binary_points]
    op, m = STANDARD[name]
    slack = SLACK if m == -1 and op != "rotate" else EXACT
    unit = size_unit(FUNCTIONS, WIDTH).unit
    for sign in (1, -1) if op == "vector" else (1,):
        check("standard", unit, [use_of(op, m, fractions, sign=sign, slack=slack)])


def test_a_unit_with_several_uses() -> None:
    unit = size_unit(FUNCTIONS, WIDTH).unit
    uses = [use_of(*STANDARD[name], FRACTIONS[n % 2]) for n, name in enumerate(STANDARD)]
    check("standard", unit, uses, 1_000)


@pytest.mark.parametrize("name", quick(STANDARD, "vector_circular", "rotate_circular", "lightcone"))
def test_steps_one_after_the_other(name: str) -> None:
    op, m = STANDARD[name]
    slack = SLACK if m == -1 and op != "rotate" else EXACT
    unit = size_unit(FUNCTIONS, WIDTH).unit
    check("standard", unit, [use_of(op, m, FRACTIONS[1], slack=slack)], 1_000, unit.iterations)


def test_several_uses_of_steps_one_after_the_other() -> None:
    unit = size_unit(FUNCTIONS, WIDTH).unit
    uses = [use_of(*STANDARD[name], FRACTIONS[n % 2]) for n, name in enumerate(STANDARD)]
    check("standard", unit, uses, 1_000, unit.iterations)


@pytest.mark.parametrize("rule", quick(["root-free", "single-rotation"], "root-free"))
@pytest.mark.parametrize("m", [1, -1])
def test_an_implicit_unit(rule: str, m: int) -> None:
    unit = size_unit(("implicit-circular", "implicit-hyperbolic"), WIDTH, rule=rule).unit
    branches = ("+", "-") if m == 1 else ("+", "-", "none")
    uses = [
        use_of("implicit", m, fractions, branch=branch, slack=slack)
        for fractions, slack in zip(FRACTIONS, (EXACT, SLACK), strict=True)
        for branch in branches
    ]
    check("implicit", unit, uses, 2_000)


def test_lengths_and_products() -> None:
    for bits in (1, 5, 8):
        b = CircuitBuilder("length")
        b.output("length", length_of(b, b.input("a", 0, (1 << bits) - 1)))
        every = np.arange(1 << bits)
        assert outputs_of(b.circuit(), {"a": every})["length"].tolist() == [
            int(n).bit_length() for n in every
        ]
    for constant in (1, 7, 45, 0b1011101):
        assert sum(sign << place for place, sign in digits_of(constant)) == constant
        b = CircuitBuilder("product")
        b.output("product", times(b, b.word("a", 6), constant))
        circuit, every = b.circuit(), np.arange(-32, 32)
        assert np.array_equal(outputs_of(circuit, {"a": every})["product"], every * constant)


def test_a_range_that_does_not_hold_is_told() -> None:
    b = CircuitBuilder("narrow")
    b.output("low", b.narrowed(b.word("a", 6), 0, 7))
    with pytest.raises(OverflowError, match="not within 0 to 7"):
        outputs_of(b.circuit(), {"a": np.array([9])})
