"""Every operation is known wherever operations are told apart, or it is said here why it is not."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
import pytest

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import SINGLE, NumberFormat, NumberSystem, Signal
from cordicc.arith.unit.cau import Cau
from cordicc.backends.c import c_units
from cordicc.backends.c.c_arithmetic import CArithmetic, COperand
from cordicc.backends.c.c_fixed import CFixedPoint
from cordicc.backends.c.c_sections import Library
from cordicc.backends.c.c_single import CSinglePrecision
from cordicc.backends.labels import SYMBOLS
from cordicc.backends.text import formulas
from cordicc.certify import operator_models
from cordicc.emulate import causes
from cordicc.expressions import syntax
from cordicc.ir.meaning import balls, doubles, enclosures, exact, rounded_operations, roundings
from cordicc.ir.ops import OPS, Level
from cordicc.ir.text import parse_graph, print_graph
from cordicc.ir.well_formed import verify
from cordicc.rewrite.search.costs import AREA_STEP, Costs
from cordicc.targets.target import FUNCTIONS_OF_KIND, function_name
from cordicc.targets.target_file import load_target, shipped_targets
from tests.support.operations import Case, cases, graph_of, plan_params

LEAVES, ARITHMETIC, FUNCTIONS, UNITS = (
    {name for name, definition in OPS.items() if definition.level is level} for level in Level
)
TOTAL = {name for name, definition in OPS.items() if not definition.partial}

CAU = Cau(rule="single-rotation")
FIXED = FixedPoint(24, 20)


def calculated(system: NumberSystem, format_: NumberFormat, op: str, params: Mapping[str, object]) -> bool:
    """Whether a number system executes an operation."""
    operand = Signal(format_.encode(np.array([0.5, 0.25])), format_)
    try:
        return bool(system.calculate(op, params, [operand] * max(1, OPS[op].arity), format_).shape)
    except ValueError:
        return False


def executed(op: str, params: Mapping[str, object]) -> bool:
    """Whether a CAU executes an operation."""
    function = getattr(CAU, op, None)
    if function is None:
        return False
    made = function(*params.values(), *[np.array([0.5, 0.25])] * OPS[op].arity)
    return len(made) == len(OPS[op].results)


def written(words: CArithmetic, format_: NumberFormat, op: str, params: Mapping[str, object]) -> bool:
    """Whether a number system of the C model writes an operation."""
    try:
        return bool(words.calculate(op, params, [COperand("a", format_)] * max(1, OPS[op].arity), format_))
    except (AssertionError, KeyError):
        return False


def unit_written(op: str, params: Mapping[str, object]) -> bool:
    """Whether the C model of units has a section for an operation."""
    library = Library()
    library.add("c_model_units.c.j2", "", c_units.unit_context(CAU, ""))
    return c_units.function(op, params)[0] in library.sections


def performed(op: str, params: Mapping[str, object]) -> bool:
    """Whether a kind of unit may have an operation among its functions."""
    m = params.get("m")
    assert m is None or isinstance(m, int)
    return any(function_name(op, m) in functions for functions in FUNCTIONS_OF_KIND.values())


def by(knows: Callable[[str, Mapping[str, object]], bool], *levels: Level) -> set[str]:
    """The operations, of some vocabularies or all, that are known with all their parameters, by trial."""
    tried = [(op, knows(op, plan_params(op, params))) for op, params in cases(*(levels or Level))]
    return {op for op, _ in tried} - {op for op, known in tried if not known}


GIVEN = {"what is no operation but given": LEAVES}
IN_PLANS = GIVEN | {"functions are gone after selection": FUNCTIONS}
OUTSIDE_UNITS = IN_PLANS | {"units have an arithmetic of their own": UNITS}
UNITS_ALONE = IN_PLANS | {"adders, multipliers and sign logic": ARITHMETIC}

PLACES: dict[str, tuple[Callable[[], Iterable[str]], dict[str, set[str]]]] = {
    "exact: ir/meaning/exact.py FOLDS": (
        lambda: exact.FOLDS,
        {"an input is no constant": {"input"}, "constants are folded before units are chosen": UNITS},
    ),
    "reference: ir/meaning/rounded_operations.py OPERATIONS": (lambda: rounded_operations.OPERATIONS, GIVEN),
    "balls: ir/meaning/balls.py OPERATIONS": (
        lambda: balls.OPERATIONS,
        GIVEN | {"few graphs with units need it: numbers of the reference do": UNITS},
    ),
    "enclosures: ir/meaning/enclosures.py ENCLOSURES": (
        lambda: enclosures.ENCLOSURES,
        {"the range of an input is given": {"input"}},
    ),
    "doubles: ir/meaning/doubles.py OPERATIONS": (
        lambda: doubles.OPERATIONS,
        {"samples of an input are given": {"input"}},
    ),
    "roundings: ir/meaning/roundings.py ERRORS": (
        lambda: roundings.ERRORS,
        {"only what a plan may hold is judged": FUNCTIONS},
    ),
    "single precision: arith/numbers/operations.py EXACT, floating.py": (
        lambda: by(lambda o, p: calculated(SingleSystem(), SINGLE, o, p)),
        OUTSIDE_UNITS,
    ),
    "fixed point: arith/numbers/operations.py EXACT, fixed_system.py": (
        lambda: by(lambda o, p: calculated(FixedSystem(24), FIXED, o, p)),
        OUTSIDE_UNITS,
    ),
    "CAU: arith/unit/cau.py Cau": (lambda: by(executed), UNITS_ALONE),
    "C of single precision: backends/c/c_single.py": (
        lambda: by(lambda o, p: written(CSinglePrecision(SingleSystem()), SINGLE, o, p)),
        OUTSIDE_UNITS,
    ),
    "C of fixed point: backends/c/c_fixed.py": (
        lambda: by(lambda o, p: written(CFixedPoint(FixedSystem(24)), FIXED, o, p)),
        OUTSIDE_UNITS,
    ),
    "C of units: backends/c/c_units.py and its template": (lambda: by(unit_written, Level.UNIT), UNITS_ALONE),
    "formulas: backends/text/formulas.py WRITERS": (lambda: formulas.WRITERS, IN_PLANS),
    "signs in pictures: backends/labels.py SYMBOLS": (
        lambda: SYMBOLS,
        IN_PLANS | {"shown with their constants": {"cmul", "shift"}},
    ),
    "error models: certify/operator_models.py MODELS": (lambda: operator_models.MODELS, IN_PLANS),
    "kinds of units: targets/target_file.py FUNCTIONS_OF_KIND": (lambda: by(performed), IN_PLANS),
    "causes of invalid samples: emulate/causes.py REASONS": (
        lambda: causes.REASONS,
        {"it always has a value": TOTAL, "no equation has units": UNITS},
    ),
    "functions of problem files: expressions/syntax.py FUNCTIONS": (
        lambda: syntax.FUNCTIONS,
        {
            "names and numbers": LEAVES,
            "written with signs": {"add", "sub", "mul", "div", "neg", "pow"},
            "made by rewriting": {"cmul", "shift", "flip", "select", "guard"},
            "an option of an output": {"wrap"},
            "a block of the file": {"solve", "solve_pair"},
            "chosen by selection": UNITS,
        },
    ),
}
"""Where operations are told apart, by file and table: what is known there and, by the reason, what is not."""


@pytest.mark.parametrize("place", PLACES)
def test_each_operation_is_known_or_it_is_said_why_not(place: str) -> None:
    knows, lacks = PLACES[place]
    known, wanted = set(knows()), set(OPS) - set().union(*lacks.values())
    assert known == wanted, f"{place}: lacks {sorted(wanted - known)}, has besides {sorted(known - wanted)}"


def test_some_shipped_target_does_each_operation_of_plans() -> None:
    targets = [load_target(name) for name in shipped_targets()]
    for op, params in cases(Level.ARITHMETIC, Level.UNIT):
        function = function_name(op, OPS[op].named(params).get("m"))
        assert any(target.kinds_for(function) for target in targets), (
            f"targets/*.yaml: no unit does {function}"
        )


@pytest.mark.parametrize("name", shipped_targets())
def test_costs_are_those_of_the_units(name: str) -> None:
    target = load_target(name)
    costs = Costs.of(target, implicit=target.has_implicit)
    for op, params in cases(Level.ARITHMETIC, Level.UNIT):
        kinds = target.kinds_for(function_name(op, OPS[op].named(params).get("m")))
        if kinds:
            unit = target.units[kinds[0]]
            assert costs.cycles(op, costs.caus(op)) == unit.latency, op
            assert costs.size(op, costs.caus(op)) == round(AREA_STEP * unit.area), op


@pytest.mark.parametrize("case", cases(*Level), ids=str)
def test_each_operation_is_well_formed_and_reads_back(case: Case) -> None:
    graph = graph_of(*case)
    verify(graph)
    assert parse_graph(print_graph(graph)) == graph
