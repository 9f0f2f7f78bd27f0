"""Units compiled by numba give the bits of the others."""

from dataclasses import asdict, replace

import numpy as np
import pytest

import cordicc
from cordicc.arith import compiled
from cordicc.emulate import functional, sampling
from cordicc.observation import machine_of
from tests.unit.test_cli import EXAMPLES
from tests.unit_words import OPERATIONS, UNITS, operands, results

needs_numba = pytest.mark.skipif(not compiled.available(), reason="numba is optional")


@needs_numba
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("name", UNITS)
def test_every_operation_has_the_same_bits(name: str) -> None:
    unit = UNITS[name]
    values = operands(1, 5000, unit.operand_bits)
    fast = compiled.CompiledCau(**asdict(unit))
    for operation, params in OPERATIONS:
        plain = results(unit, operation, params, values)
        for at, bits in enumerate(results(fast, operation, params, values)):
            assert np.array_equal(plain[at], bits), (operation, params, at)


@needs_numba
@pytest.mark.filterwarnings("default")
def test_operands_may_be_broadcast() -> None:
    unit = UNITS["single"]
    fast = compiled.CompiledCau(**asdict(unit))
    x = np.array([0.5, -0.25, 1.0])
    for plain, made in zip(unit.rotate(1, x, 0.25, 1.0), fast.rotate(1, x, 0.25, 1.0), strict=True):
        assert np.array_equal(plain, made)
    with pytest.raises(ValueError, match="no implicit mode"):
        replace(fast, rule=None).implicit(1, "+", x, x, x)


@needs_numba
@pytest.mark.filterwarnings("default")
def test_long_runs_take_compiled_units(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = cordicc.compile(EXAMPLES / "planar_2r.yaml")
    machine = machine_of(plan)
    samples = sampling.draw(plan.problem, 500, 0)
    plain = functional.run(plan, machine, samples)
    monkeypatch.setattr(functional, "_COMPILED_FROM", 1)
    assert compiled.is_compiled(functional.accelerated(plan, machine, samples, 500))
    fast = functional.run(plan, machine, samples)
    assert all(np.array_equal(plain[name], fast[name]) for name in plain)


def test_without_numba_nothing_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = cordicc.compile(EXAMPLES / "planar_2r.yaml")
    machine = machine_of(plan)
    monkeypatch.setattr(functional, "_COMPILED_FROM", 1)
    monkeypatch.setattr(functional, "available", lambda: False)
    assert functional.accelerated(plan, machine, sampling.draw(plan.problem, 5, 0), 5) is machine
