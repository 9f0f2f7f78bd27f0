"""Units compiled by numba give the bits of the others."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from cordicc.arith.compiled import compiled_cau
from cordicc.arith.compiled.compiled_systems import CompiledSingle, compiled_system
from cordicc.arith.kernels.reduction import quarter_turns
from cordicc.arith.numbers.fixed_point import ROUNDINGS, FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import SINGLE, BinaryPoint, Signal
from cordicc.arith.unit.cau import Cau
from cordicc.emulate import functional
from cordicc.ir import sampling
from tests.support.paths import EXAMPLES
from tests.support.plans import planned
from tests.support.selection import slow
from tests.support.unit_words import OPERATIONS, UNITS, operands, results

needs_numba = pytest.mark.skipif(not compiled_cau.available(), reason="numba is optional")


@needs_numba
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("name", UNITS)
def test_every_operation_has_the_same_bits(name: str) -> None:
    unit = UNITS[name]
    values = operands(1, 5000, unit.operand_bits)
    fast = compiled_cau.CompiledCau(**asdict(unit))
    for operation, params in OPERATIONS:
        plain = results(unit, operation, params, values)
        for at, bits in enumerate(results(fast, operation, params, values)):
            assert np.array_equal(plain[at], bits), (operation, params, at)


@needs_numba
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("angle_bits", [24, 35])
def test_rotations_by_a_table_have_the_same_bits(angle_bits: int) -> None:
    unit = Cau(33, 30, None, 24, angle_bits)
    fast = compiled_cau.CompiledCau(**asdict(unit))
    generator = np.random.Generator(np.random.PCG64(3))
    x, y = np.ldexp(generator.integers(-(2**23), 2**23, (2, 1300)).astype(float), -20)
    words = generator.integers(1 - 2**23, 2**23, 1300) >> generator.integers(0, 24, 1300)
    words[:4] = 0, 2**23 - 1, 1 - 2**23, -(2**23)
    lengths = set()
    for fraction in (18, 19, 20, 21, 22, 24, 26, 37, 160):  # 18: too many quarter turns, so a product
        table = quarter_turns(angle_bits, 24, fraction)
        lengths.add(None if table is None else len(table.thresholds))
        z = FixedPoint(24, fraction).decode(words)
        made = fast.rotate(1, x, y, z, quarters=table)
        for plain, same in zip(unit.rotate(1, x, y, z, quarters=table), made, strict=True):
            assert np.array_equal(plain, same, equal_nan=True)
            assert np.array_equal(np.isnan(plain), words == -(2**23))
    assert lengths == {None, 0, 1, 3, 5, 10}


@needs_numba
@pytest.mark.filterwarnings("default")
def test_operands_may_be_broadcast() -> None:
    unit = UNITS["single"]
    fast = compiled_cau.CompiledCau(**asdict(unit))
    x = np.array([0.5, -0.25, 1.0])
    for plain, made in zip(unit.rotate(1, x, 0.25, 1.0), fast.rotate(1, x, 0.25, 1.0), strict=True):
        assert np.array_equal(plain, made)
    with pytest.raises(ValueError, match="no implicit mode"):
        replace(fast, rule=None).implicit(1, "+", x, x, x)


@needs_numba
@pytest.mark.filterwarnings("default")
def test_long_runs_take_compiled_units(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planned(EXAMPLES / "planar_2r.yaml")
    machine = plan.arithmetic
    samples = sampling.draw(plan.problem.workspace, 500, 0)
    plain = functional.run(plan, machine, samples)
    monkeypatch.setattr(functional, "COMPILED_FROM", 1)
    assert compiled_cau.is_compiled(functional.accelerated(plan, machine, samples, 500))
    fast = functional.run(plan, machine, samples)
    assert all(np.array_equal(plain[name], fast[name]) for name in plain)


def singles(seed: int, count: int) -> np.ndarray:
    """Return singles of every size, zeros, subnormal, largest and invalid ones among them."""
    generator = np.random.Generator(np.random.PCG64(seed))
    words = generator.integers(0, 2**32, count, dtype=np.uint32).view(np.float32)
    words[~np.isfinite(words)] = np.nan
    near = (generator.uniform(-2, 2, count) * 2.0 ** generator.integers(-3, 3, count)).astype(np.float32)
    odd = np.array([0.0, -0.0, np.nan, 1e-45, -1e-45, 3.4028235e38, -3.4028235e38, 1.1754944e-38], np.float32)
    mixed = np.where(generator.random(count) < 0.5, words, near)
    return np.where(generator.random(count) < 0.2, generator.choice(odd, count), mixed)


@needs_numba
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("op", ["add", "sub", "mul", "cmul", "min"])
def test_adders_and_multipliers_have_the_same_bits(op: str) -> None:
    fast, plain = CompiledSingle(), SingleSystem()
    operands = [Signal(singles(seed, 50_000), SINGLE) for seed in (1, 2)]
    for factor in ("0.1", "-3.4e38", "1.2e-38", "1.0"):
        params = {"factor": factor} if op == "cmul" else {}
        taken = operands[:1] if op == "cmul" else operands
        expected = plain.calculate(op, params, taken, SINGLE)
        made = fast.calculate(op, params, taken, SINGLE)
        assert made.dtype == expected.dtype == np.float32
        assert np.array_equal(np.isnan(made), np.isnan(expected))
        held = ~np.isnan(made)
        assert np.array_equal(made[held].view(np.uint32), expected[held].view(np.uint32))
    one = Signal(np.asarray(np.float32(0.5)), SINGLE)
    broadcast = fast.calculate("add", {}, [operands[0], one], SINGLE)
    assert np.array_equal(broadcast, plain.calculate("add", {}, [operands[0], one], SINGLE), equal_nan=True)
    assert fast.spec() == plain.spec()


@needs_numba
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("fractions", [(20, 20, 20), (3, 30, 18), (25, 12, 40), (-40, 5, -60), (0, 29, 31)])
def test_fixed_point_has_the_same_bits(rounding: str, fractions: tuple[int, int, int]) -> None:
    plain = FixedSystem(24, 6, rounding)
    fast = compiled_system(plain)
    assert fast.spec() == plain.spec()
    generator = np.random.Generator(np.random.PCG64(2))
    specs = [BinaryPoint(30, fraction) for fraction in fractions]
    words = [generator.integers(-(2**29), 2**29, 20_000) >> generator.integers(0, 29, 20_000) for _ in "ab"]
    for each in words:
        each[:50] = -(2**29)
    numbers = np.ldexp(generator.permutation(words[0]).astype(float), 1 - fractions[2]) / 4
    numbers[:3] = np.nan, np.inf, -1e300
    made = []
    for system in (plain, fast):
        *formats, result = (system.format(spec) for spec in specs)
        operands = [Signal(each, format_) for each, format_ in zip(words, formats, strict=True)]
        found = [system.calculate(op, {}, operands, result) for op in ("add", "sub", "mul", "min")]
        found += [system.calculate("cmul", {"factor": f}, operands[:1], result) for f in ("0.3", "-1e9")]
        found += [system.calculate("add", {}, [operands[0], system.constant("0.75")], result)]
        found += [format_.decode(each) for each, format_ in zip(words, formats, strict=True)]
        made.append([*found, result.encode(numbers), result.encode_angle(numbers)])
    for expected, same in zip(*made, strict=True):
        assert expected.dtype == same.dtype
        assert np.array_equal(expected, same, equal_nan=True)


@needs_numba
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(
    ("name", "target"),
    [("quadruped_leg", "kinematic"), slow(("quadruped_leg", "fixed24")), ("wheel_beta", "fixed24")],
)
def test_a_plan_has_the_same_bits(name: str, target: str) -> None:
    plan = planned(EXAMPLES / f"{name}.yaml", target=target)
    machine = plan.arithmetic
    samples = sampling.draw(plan.problem.workspace, 3000, 4)
    plain = functional.run(plan, machine, samples)
    fast = functional.run(plan, compiled_cau.compiled_arithmetic(machine), samples)
    for name, column in plain.items():
        assert np.array_equal(column, fast[name], equal_nan=True)


def test_without_numba_nothing_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planned(EXAMPLES / "planar_2r.yaml")
    machine = plan.arithmetic
    monkeypatch.setattr(functional, "COMPILED_FROM", 1)
    monkeypatch.setattr(functional, "available", lambda: False)
    assert functional.accelerated(plan, machine, sampling.draw(plan.problem.workspace, 5, 0), 5) is machine
