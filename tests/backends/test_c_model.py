"""The C model: names, diagnostics and CSV, and the same bits as the emulator for every operation."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cordicc.arith.kernels.reduction import quarter_turns
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.formats import BinaryPoint, Signal
from cordicc.backends.c import c_model
from cordicc.backends.c.c_arithmetic import COperand
from cordicc.backends.c.c_names import comment, identifiers
from cordicc.base.diagnostics import Unattainable
from cordicc.emulate import functional
from cordicc.plan.model import Formats, Operand, Operation, Plan
from cordicc.targets.target_file import load_target
from tests.support import command_line
from tests.support.c_models import (
    SANITIZED,
    Generator,
    adversarial,
    build,
    check,
    needs_compiler,
    run,
    variants,
)
from tests.support.origins import problem_of
from tests.support.paths import EXAMPLES
from tests.support.selection import quick, slow

WIDE = {"mantissa_bits": 43, "exponent_bits": 10, "angle_bits": 44, "iterations": 40}


@cache
def arithmetic(name: str) -> dict[str, Any]:
    """Return the arithmetic of a shipped target, or of one that is as far from them as can be."""
    if name == "fixed32":
        units = {"standard": WIDE, "implicit": {**WIDE, "rule": "single-rotation"}}
        return {
            "format": {"kind": "fixed-point", "width": 32, "guard": 0, "rounding": "half-even"},
            "units": units,
        }
    if name == "fixed12":
        shipped = load_target("fixed24").arithmetic["units"]
        units = {**shipped, "implicit": {**shipped["implicit"], "rule": "root-free"}}
        return {
            "format": {"kind": "fixed-point", "width": 12, "guard": 2, "rounding": "floor"},
            "units": units,
        }
    return load_target(name, guard_bits=3).arithmetic


CAU_VARIANTS = [v for v in variants() if v[0] in ("rotate", "vector", "lightcone", "implicit")]
OTHER_VARIANTS = [v for v in variants() if v not in CAU_VARIANTS]


def label(case: tuple[str, dict[str, Any]]) -> str:
    return "-".join([case[0], *(str(value) for value in case[1].values())])


@needs_compiler
@pytest.mark.parametrize("case", CAU_VARIANTS, ids=label)
@pytest.mark.parametrize(
    ("target", "seed"), [slow(("kinematic", 3)), slow(("krieger96", 4)), ("fixed24", 5), slow(("fixed32", 6))]
)
def test_unit_operations(case: tuple[str, dict[str, Any]], target: str, seed: int, tmp_path: Path) -> None:
    plan = Generator(arithmetic(target), seed).plan([case], 4)
    check(plan, adversarial(plan.problem, 800, seed), tmp_path)


@needs_compiler
@pytest.mark.parametrize(
    "target", ["kinematic", slow("krieger96"), "fixed24", slow("fixed32"), slow("fixed12")]
)
@pytest.mark.parametrize("seed", quick(range(4), 0))
def test_random_graphs(target: str, seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    cases = variants()
    operations = [cases[index] for index in rng.integers(0, len(cases), 10)]
    plan = Generator(arithmetic(target), seed).plan(operations, 4, wide=seed % 2 == 1)
    check(plan, adversarial(plan.problem, 800, seed), tmp_path, *SANITIZED)


@needs_compiler
@pytest.mark.parametrize("target", [slow("kinematic"), "fixed24", slow("fixed12")])
@pytest.mark.parametrize("case", OTHER_VARIANTS, ids=label)
def test_adders_multipliers_and_sign_logic(
    case: tuple[str, dict[str, Any]], target: str, tmp_path: Path
) -> None:
    plan = Generator(arithmetic(target), 1).plan([case], 3)
    check(plan, adversarial(plan.problem, 500, 1), tmp_path)


@needs_compiler
def test_rotations_by_angles_of_every_format(tmp_path: Path) -> None:
    """No quarter turn, one, ten and more than a table holds; more bits than the unit has, and fewer."""
    spec = arithmetic("fixed24")
    angle_bits = spec["units"]["standard"]["angle_bits"]
    fractions = (17, 18, 19, 20, 21, 22, 23, 24, angle_bits + 2, angle_bits + 9, 160)
    tables = [quarter_turns(angle_bits, 24, fraction) for fraction in fractions]
    assert {None if table is None else len(table.thresholds) for table in tables} == {None, 0, 1, 3, 5, 10}
    values = {"x": BinaryPoint(24, 22), "y": BinaryPoint(24, 22)}
    ranges = {"x": (-1.9, 1.9), "y": (-1.9, 1.9)}
    outputs, made = {}, []
    for index, fraction in enumerate(fractions):
        angle, largest = f"z{index}", math.ldexp((1 << 23) - 1, -fraction)
        values[angle], ranges[angle] = BinaryPoint(24, fraction), (-largest, largest)
        results = (f"o{index}.c", f"o{index}.s")
        operands = tuple(Operand(value=name) for name in ("x", "y", angle))
        mode = ("rotate", {"m": 1}, "standard", "rotate", "standard")
        made.append(Operation(f"o{index}", *mode, 0, 0, ("x", "y", "z"), operands, results, f"eq{index}"))
        values |= {name: BinaryPoint(27, 24) for name in results}
        outputs |= {f"c{index}": Operand(value=results[0]), f"s{index}": Operand(value=results[1])}
    shapes = {name: BinaryPoint(24, 21) for name in outputs}
    plan = replace(
        Generator(spec, 1).plan([("rotate", {"m": 1})], 1),
        problem=problem_of("rotations", ranges, outputs),
        operations=tuple(made),
        outputs=outputs,
        formats=Formats(values, shapes),
    )
    found = check(plan, adversarial(plan.problem, 600, 1), tmp_path, *SANITIZED)
    assert found["valid"].sum() > 300
    (text,) = (text for name, text in c_model.files(plan).items() if name.endswith(".c"))
    shared = {table for table in tables if table is not None}
    assert text.count("static const quarter_turns quarters_") == len(shared) < len(tables) - 2
    assert text.count("phase(z)") == 1


@needs_compiler
def test_binary_points_as_far_apart_as_formats_allow(tmp_path: Path) -> None:
    """Shifts of 63 places and more, in sums, comparisons and conversions, without undefined behaviour."""
    cases = [(op, {}) for op in ("add", "sub", "min", "max", "flip", "select", "neg", "abs")] * 8
    plan = Generator(arithmetic("fixed24"), 3).plan(cases, 4, wide=True)
    shapes = {name: point.fraction for name, point in plan.formats.values.items()}
    sums = [o for o in plan.operations if o.op in ("add", "sub")]
    apart = [
        abs(shapes[str(a.value)] - shapes[str(b.value)])
        for a, b in (o.operands for o in sums if all(v.value for v in o.operands))
    ]
    assert sum(places >= 63 for places in apart) >= 3
    check(plan, adversarial(plan.problem, 300, 3), tmp_path, *SANITIZED)


@pytest.mark.parametrize("seed", range(60))
def test_sums_of_far_binary_points_fit_and_round_once(seed: int) -> None:
    """The C expressions are Python too, but for their helpers; integers here have no limit."""
    rng = np.random.default_rng(seed)
    system = FixedSystem(24, 4, str(rng.choice(["half-up", "half-even", "floor"])))
    spread = int(rng.integers(0, 120))
    a, b, to = (system.format(BinaryPoint(28, int(f))) for f in (0, spread, int(rng.integers(-40, 160))))
    words = c_model.CFixedPoint(system)
    names = {"a": a, "b": b}
    order = ["a", "b"] if rng.random() < 0.5 else ["b", "a"]
    op = str(rng.choice(["add", "sub"]))
    expression = words.calculate(op, {}, [COperand(n, names[n]) for n in order], to)
    for _ in range(60):
        values = {n: int(rng.integers(-(2**27) + 1, 2**27) >> rng.integers(0, 27)) for n in "ab"}
        signals = [Signal(np.array([values[n]]), names[n]) for n in order]
        (wanted,) = system.calculate(op, {}, signals, to)
        assert evaluate(expression, values, to.rounding) == wanted


@pytest.mark.parametrize("op", ["min", "max"])
@pytest.mark.parametrize("constant", ["-1", "0", "1", "0.001"])
@pytest.mark.parametrize("fraction", [-40, 20, 27, 60])
def test_comparisons_are_ones_that_can_go_either_way(op: str, constant: str, fraction: int) -> None:
    """Compilers warn of a word compared with a constant that no word of its type reaches."""
    words = c_model.CFixedPoint(FixedSystem(24, 4, "floor"))
    format_ = words.system.format(BinaryPoint(28, fraction))
    given = COperand("a", format_), words.constant(constant)
    expression = words.calculate(op, {}, given, format_)
    decided = constant != "0" and abs(float(constant)) > format_.largest_word * format_.ulp
    assert expression.startswith(("1 ?", "0 ?") if decided else "(int64_t)a ")
    if decided:
        assert (expression[0] == "1") == ((float(constant) > 0) == (op == "min"))


def evaluate(expression: str, values: dict[str, int], rounding: str) -> int:
    """Evaluate a C expression of a sum, with a check that every integer fits 64 bits."""

    def word(number: int, width: int) -> int:
        return number if abs(number) < 2 ** (width - 1) else -(2 ** (width - 1))

    def rounded(number: int, right: int, width: int) -> int:
        assert abs(number) < 2**62
        assert abs(right) <= 63
        if right <= 0:
            return word(number << -right, width)
        odd = (number >> right) & 1
        half = {"half-up": 1 << (right - 1), "half-even": (1 << (right - 1)) - 1 + odd, "floor": 0}
        return word((number + half[rounding]) >> right, width)

    helpers = {
        "word": word,
        "rounded": rounded,
        "sticky": lambda number, count: (number >> count) | (number % (1 << count) != 0),
        "within": lambda number, limit: max(-limit, min(limit, number)),
        "INT64_C": int,
    }
    return int(eval(expression.replace("(int64_t)", ""), {}, {**helpers, **values}))


def planar(name: str = "planar 2r") -> Plan:
    plan = Generator(arithmetic("fixed24"), 1).plan([("add", {}), ("vector", {"m": 1, "sign": 1})], 2)
    return replace(plan, problem=replace(plan.problem, name=name))


def test_names_that_c_does_not_allow() -> None:
    names = ["x", "int", "int_", "NAN", "valid", "a.b", "a_b", "4bar", "_x", "EOF", "Ä", "template"]
    found = identifiers(names)
    assert list(found.values())[:4] == ["x", "int_", "int__", "NAN_"]
    assert len(set(found.values())) == len(names)
    assert all(made.isascii() and made.isidentifier() for made in found.values())


def test_comments_stay_comments() -> None:
    assert comment("a */ b /* c ??/ \n d \\ \x00") == "a * / b / * c ? ?/ d /"


def test_files_are_named_after_the_plan_and_always_the_same() -> None:
    files = c_model.files(planar())
    assert list(files) == ["planar_2r.c", "planar_2r.h"]
    assert files == c_model.files(planar())


def test_an_angle_without_fraction_bits_cannot_be_wrapped() -> None:
    plan = Generator(arithmetic("fixed24"), 1).plan([("wrap", {})], 1)
    operations = (replace(plan.operations[0], operands=(Operand(value="x0"),)),)
    values = {**plan.formats.values, "x0": BinaryPoint(24, -3)}
    plan = replace(plan, operations=operations, formats=replace(plan.formats, values=values))
    with pytest.raises(Unattainable, match="E420"):
        c_model.files(plan)


@needs_compiler
def test_hostile_names_and_texts(tmp_path: Path) -> None:
    plan = planar("*/ #error")
    renamed = {"x0": "int", "x1": "EOF"}
    inputs = tuple(replace(item, name=renamed[item.name], unit="*/ ??/") for item in plan.problem.inputs)
    values = {renamed.get(name, name): spec for name, spec in plan.formats.values.items()}
    operations = tuple(
        replace(
            o,
            operands=tuple(replace(v, value=renamed.get(str(v.value), v.value)) for v in o.operands),
            equation="a\\\n*/",
        )
        for o in plan.operations
    )
    plan = replace(
        plan,
        problem=replace(plan.problem, description="line one */\nline two", inputs=inputs),
        operations=operations,
        formats=replace(plan.formats, values=values),
    )
    check(plan, adversarial(plan.problem, 100, 1), tmp_path)


@needs_compiler
def test_without_main_it_is_a_library(tmp_path: Path) -> None:
    files = c_model.files(planar())
    assert build(files, tmp_path, "-c", "-DCORDICC_NO_MAIN").exists()


@needs_compiler
@pytest.mark.parametrize("target", [slow("kinematic"), "fixed24"])
def test_compiler_dialects_and_optimisation_change_nothing(target: str, tmp_path: Path) -> None:
    """All headers' own names are visible here, and products may be fused with sums where the machine can."""
    plan = Generator(arithmetic(target), 2).plan(variants()[:20] + CAU_VARIANTS, 4)
    check(plan, adversarial(plan.problem, 800, 2), tmp_path, "-std=gnu11", "-D_GNU_SOURCE", "-O3")


@needs_compiler
def test_csv_in_any_order_with_extra_columns(tmp_path: Path) -> None:
    plan = planar()
    program = build(c_model.files(plan), tmp_path, *SANITIZED)
    text = '\ufeffnote, x1 ,"x0"\r\n"a, ""b""", 0.125 , +5e-2\r\n\r\nc,1e9,"0.25"\nd,-0.0,.5'
    done = run(program, text)
    assert done.returncode == 0, done.stderr
    wanted = functional.run(plan, plan.arithmetic, {"x0": [0.05, 0.25, 0.5], "x1": [0.125, 1e9, -0.0]})
    header, *rows = done.stdout.splitlines()
    assert header == ",".join(wanted)
    assert [row.split(",")[-1] for row in rows] == [str(int(ok)) for ok in wanted["valid"]]
    first = next(iter(wanted))
    np.testing.assert_array_equal([float(row.split(",")[0]) for row in rows], wanted[first])


@needs_compiler
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "stdin:0: error: the input is empty"),
        ("x0\n1\n", "stdin:1: error: a column is missing: x1"),
        ("x0,x1,x0\n", "stdin:1: error: a column occurs twice: x0"),
        ("x0,x1\n1\n", "stdin:2: error: another number of fields than in the header"),
        ("x0,x1\n1,2,3\n", "stdin:2: error: another number of fields than in the header"),
        ("x0,x1\n1,2\n1,0x1p3\n", "stdin:3: error: not a decimal number: 0x1p3"),
        ("x0,x1\n1,\n", "stdin:2: error: not a decimal number: "),
        ("x0,x1\n1,nan\n", "stdin:2: error: not a decimal number: nan"),
        ("x0,x1\n1,1e999\n", "stdin:2: error: not a finite number: 1e999"),
        ('x0,x1\n1,"2\n', "stdin:2: error: a quote is not closed"),
    ],
)
def test_csv_that_cannot_be_read(text: str, message: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    done = run(reader(tmp_path_factory), text)
    assert done.returncode == 2
    assert done.stderr == f"{message}\n"


_PROGRAMS: list[Path] = []


def reader(factory: pytest.TempPathFactory) -> Path:
    if not _PROGRAMS:
        _PROGRAMS.append(build(c_model.files(planar()), factory.mktemp("reader"), *SANITIZED))
    return _PROGRAMS[0]


def test_emit_c_writes_the_model_beside_the_plan(tmp_path: Path) -> None:
    problem = EXAMPLES / "planar_2r.yaml"
    done = command_line.run("compile", problem, "--emit", "c", "-o", tmp_path)
    assert done.exit_code == 0, done.output
    assert "planar_2r.c, planar_2r.h" in done.output
    assert {"plan.json", "planar_2r.c", "planar_2r.h"} <= {path.name for path in tmp_path.iterdir()}
