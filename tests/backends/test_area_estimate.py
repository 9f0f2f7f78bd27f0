"""Estimates of area: bits of circuits by kind, and what they are multiplied by."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from cordicc.arith.circuits.builder import CircuitBuilder
from cordicc.arith.circuits.cell_delays import Clocking
from cordicc.arith.circuits.circuit import Circuit
from cordicc.backends.synthesis.cell_bits import FF_KINDS, LUT_KINDS, cell_bits, choice_luts, fifo_bits
from cordicc.backends.synthesis.estimate import area_of, estimated_area, measured_bits, relative, table_name
from cordicc.targets.device import DEVICES
from tests.support.paths import ROOT
from tests.support.plans import compiled

ECP5, XC7, GENERIC = (DEVICES[name] for name in ("ecp5-85k", "artix7-100t", "generic"))


def logic() -> Circuit:
    b = CircuitBuilder("logic")
    x, y = b.word("x", 8), b.word("y", 8)
    c, n = b.input("c", 0, 1), b.input("n", 0, 3)
    b.output("sum", x + y)
    b.output("turned", b.addsub(x, y, c))
    b.output("less", x < y)
    b.output("chosen", b.mux(c, x, y))
    b.output("entry", b.pick(n, [1, 9, 4, 200]))
    _ = x * y  # nobody takes it
    return b.circuit()


def test_bits_are_counted_by_kind() -> None:
    # A comparison is the sign of a difference.
    expected = {"add": 9 + 9 + 9, "turn": 8, "mux": 8, "pick": 8}
    assert {kind: n for kind, n in cell_bits(logic(), ECP5).items() if n} == expected


def test_registers_in_a_row_are_apart() -> None:
    b = CircuitBuilder("rows", Clocking(5.0))
    x, y = b.word("x", 8), b.word("y", 4)
    b.output("late", x)
    b.output("sum", y + 1)
    assert {k: n for k, n in cell_bits(b.circuit(5), XC7).items() if k in FF_KINDS} == {
        "row": 8 * 5 + 5 * 5,
        "delay": 8 + 5,
    }
    assert {k: n for k, n in cell_bits(b.circuit(2), XC7).items() if k in FF_KINDS} == {"register": 13 * 2}
    assert {k: n for k, n in cell_bits(b.circuit(5), ECP5).items() if k in FF_KINDS} == {"register": 13 * 5}
    assert fifo_bits(25, 2, XC7) == {"register": 50}
    assert fifo_bits(25, 40, XC7) == {"row": 1000, "delay": 50}
    assert fifo_bits(25, 40, ECP5) == {"register": 1000}


@pytest.mark.parametrize(
    ("wide", "narrow", "ecp5", "xc7"), [(18, 18, 1, 1), (24, 24, 4, 2), (35, 18, 2, 2), (41, 30, 6, 4)]
)
def test_blocks_of_a_product(wide: int, narrow: int, ecp5: int, xc7: int) -> None:
    b = CircuitBuilder("product")
    b.output("p", b.word("x", wide) * b.word("y", narrow))
    circuit = b.circuit()
    assert (cell_bits(circuit, ECP5)["block"], cell_bits(circuit, XC7)["block"]) == (ecp5, xc7)
    assert cell_bits(circuit, GENERIC) == {"array": (wide - 1) * (narrow - 1)}


def test_a_product_with_a_constant_has_rows_for_its_digits() -> None:
    b = CircuitBuilder("product")
    b.output("p", b.word("x", 11) * 0b1110111)  # 1000 -1 00 -1, three digits
    assert cell_bits(b.circuit(), GENERIC) == {"array": 10 * 3}


def test_choices_in_front_of_a_port() -> None:
    assert choice_luts(24, 1, ECP5) == 0
    assert choice_luts(24, 2, ECP5) == 24
    assert choice_luts(24, 4, ECP5) == 3 * 24
    assert choice_luts(24, 4, XC7) == 2 * 24


def test_the_table_has_every_chip_and_its_error() -> None:
    table = measured_bits()
    assert set(table) == {table_name(device) for device in DEVICES.values()}
    for entry in table.values():
        assert set(entry["lut"]) <= set(LUT_KINDS)
        assert set(entry["ff"]) <= set(FF_KINDS)
        assert entry["error"]["lut"]["rms"] < 0.25
        assert entry["error"]["ff"]["rms"] < 0.1
        assert min([*entry["lut"].values(), *entry["ff"].values(), *entry["dsp"].values()]) >= 0


def test_twice_the_bits_are_twice_the_area() -> None:
    once, twice = (area_of({"add": n, "register": n, "block": n, "lut": n}, ECP5) for n in (1000, 2000))
    assert twice.lut == pytest.approx(2 * once.lut, abs=2)
    assert (once.lut, once.ff) > (1000, 500)
    assert relative(110, 100) == pytest.approx(0.1)
    assert relative(1, 0) == float("inf")
    assert relative(0, 0) == 0


def test_a_plan_on_a_chip_has_an_area(tmp_path: Path) -> None:
    plans = [
        compiled(ROOT / "examples" / "planar_2r.yaml", target="ecp5", ii=ii, certify=False) for ii in (1, 4)
    ]
    single, shared = (estimated_area(plan) for plan in plans)
    assert single is not None
    assert shared is not None
    assert single == plans[0].estimate
    assert 0.4 * single.lut < shared.lut < 0.8 * single.lut


@pytest.fixture(scope="module")
def benchmark() -> ModuleType:
    spec = importlib.util.spec_from_file_location("units_area", ROOT / "benchmarks" / "units_area.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("steps", [1, 30])
def test_the_fit_finds_what_bits_take(benchmark: ModuleType, steps: int) -> None:
    rows = [{"add": 100 * i, "mux": 40 * j} for i in range(1, 6) for j in range(1, 6)]
    counts = [round(1.2 * row["add"] + 0.5 * row["mux"]) for row in rows]
    found = benchmark.fitted(rows, counts, ("add", "mux", "logic"), 0, steps)
    assert found == {"add": pytest.approx(1.2, abs=0.03), "mux": pytest.approx(0.5, abs=0.06)}
    falling = benchmark.fitted(rows, [row["add"] - row["mux"] // 4 for row in rows], ("add", "mux"), 0, steps)
    assert min(falling.values()) >= 0


def test_one_that_is_far_off_does_not_draw_the_others(benchmark: ModuleType) -> None:
    rows = [{"register": 100 * i} for i in range(1, 7)]
    counts = [90 * i for i in range(1, 7)]
    counts[2] *= 4
    plain, robust = (benchmark.fitted(rows, counts, ("register",), 0, steps)["register"] for steps in (1, 30))
    assert robust == pytest.approx(0.9, abs=0.01)
    assert abs(plain - 0.9) > 0.02


def test_bits_below_a_shifted_number_are_no_flip_flops() -> None:
    b = CircuitBuilder("shifted", Clocking(5.0))
    b.output("late", b.mux(b.input("c", 0, 1), b.word("x", 8) << 500, b.word("y", 8) << 499))
    assert cell_bits(b.circuit(4), ECP5)["register"] <= 4 * (2 * 9 + 1)


@pytest.mark.exhaustive(reason="makes circuits of all units")
def test_circuits_of_all_units_are_measured(benchmark: ModuleType) -> None:
    made = dict(benchmark.circuits(16))
    assert len(made) == len(benchmark.FUNCTIONS) + len(benchmark.OPERATIONS)
    assert all(cell_bits(circuit, ECP5).get("register", 0) for circuit in made.values())
