"""The operations of a plan with exact constants and number formats: what its errors are counted on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.arith.kernels.blocks import ZERO_EXPONENT
from cordicc.arith.kernels.reduction import QuarterTurns
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.formats import NumberFormat
from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.arith.unit.arithmetic import Arithmetic, least_exponent
from cordicc.arith.unit.cau import Cau
from cordicc.base.arrays import Floats
from cordicc.emulate.ports import PortFormats
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.ops import Level, angle_result
from cordicc.ir.ranges.contraction import contracted
from cordicc.ir.ranges.forward import value_ranges
from cordicc.plan.model import Operand, Operation, Plan


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant operand: its enclosure, and how far its word is from it."""

    interval: Interval
    error: float


@dataclass(frozen=True, slots=True)
class Step:
    """An operation: names of operands and of results (None: nobody takes it), formats, the unit.

    factor: the exact factor of a `cmul` and the error of its word.
    turns: by result, whether it may be enclosed a turn off, which makes no difference where it is taken.
    exact: the first result needs no rounding, if it is of integers or an operand passed on.
    spacing: the last place of the first operand.
    sizes: the largest magnitudes of results with `turns`, which may be enclosed a turn off; 0 for others.
    slack: what counts as on the border of the domain.
    quarters: the table by which a circular rotation reduces its angle, if it does by one.
    least: the exponent that its block has at least.
    """

    id: str
    op: str
    params: Mapping[str, Any]
    equation: str
    cau: Cau | None
    operands: tuple[str | Constant, ...]
    results: tuple[str | None, ...]
    formats: tuple[NumberFormat | None, ...]
    factor: Constant | None
    turns: tuple[bool, ...]
    exact: bool
    spacing: float
    sizes: tuple[float, ...]
    slack: Slack = EXACT
    quarters: QuarterTurns | None = None
    least: int = ZERO_EXPONENT


def known_norm(step: Step) -> bool:
    """Tell whether A or B of an implicit operation is the constant 0, so that the other one is its norm."""
    return any(isinstance(o, Constant) and o.interval.magnitude == 0 for o in step.operands[:2])


@dataclass(frozen=True, slots=True)
class ErrorNetwork:
    """The steps in order of dependence, inputs and outputs.

    `proven` holds enclosures of the exact values of valid samples by name.
    """

    steps: tuple[Step, ...]
    inputs: Mapping[str, Interval]
    outputs: Mapping[str, str | Constant]
    angles: Mapping[str, bool]
    formats: PortFormats
    proven: Mapping[str, Interval]

    def upstream(self, output: str) -> tuple[Step, ...]:
        """Return the steps that an output depends on."""
        return self._making({self.outputs[output]})

    def before(self, step: Step) -> tuple[Step, ...]:
        """Return a step and those that it depends on."""
        return (*self._making(set(step.operands)), step)

    def needed(self, steps: Sequence[Step], besides: Sequence[str | Constant]) -> set[str]:
        """Return the inputs that some steps or operands take."""
        taken = {*besides, *(operand for step in steps for operand in step.operands)}
        return {name for name in self.inputs if name in taken}

    def _making(self, wanted: set[str | Constant]) -> tuple[Step, ...]:
        found = []
        for step in reversed(self.steps):
            if any(result in wanted for result in step.results if result is not None):
                found.append(step)
                wanted.update(step.operands)
        return tuple(reversed(found))


def network(plan: Plan) -> ErrorNetwork:
    """Return the network of a plan that holds its unit program."""
    graph = plan.unit_program
    assert graph is not None, "there is no unit program"
    arithmetic = plan.arithmetic
    formats = PortFormats.of(plan, arithmetic)
    operations = {operation.id: operation for operation in plan.operations}
    made = [i for i, node in enumerate(graph.nodes) if node.definition.level is not Level.LEAF]
    ranges = {item.name: Interval(item.lo, item.hi) for item in plan.problem.inputs}
    enclosures = contracted(graph, value_ranges(graph, ranges))
    angles = plan.problem.angles
    whole_turns = _whole_turns(graph, angles) & _turned(graph)
    proven: dict[str, Interval] = {}
    steps = []
    for number, index in enumerate(made, 1):
        node, operation = graph.nodes[index], operations[f"o{number}"]
        assert node.op == operation.op, f"{operation.id} is {operation.op}, not {node.op}"
        operands = tuple(
            _operand(arithmetic, o, graph.constant(v))
            for o, v in zip(operation.operands, node.operands, strict=True)
        )
        turns = tuple(Value(index, result) in whole_turns for result in range(len(operation.results)))
        factor = None
        if node.op == "cmul":
            factor = _constant(arithmetic, str(operation.params["factor"]), node.factor)
        for name, interval, free in zip(operation.results, enclosures[index], turns, strict=True):
            if name is not None and interval is not None and not free:
                proven[name] = interval
        steps.append(
            Step(
                operation.id,
                operation.op,
                operation.params,
                operation.equation,
                arithmetic.caus.get(operation.kind),
                operands,
                operation.results,
                tuple(formats.of_results(operation)),
                factor,
                turns,
                _exact(arithmetic, formats, operation),
                _spacing(formats, operation),
                tuple(_sizes(enclosures[index], turns)),
                operation.slack,
                _quarters(arithmetic, formats, operation),
                _least(arithmetic, formats, operation),
            )
        )
    outputs = {
        name: _operand(arithmetic, operand, graph.constant(graph.outputs[name]))
        for name, operand in plan.outputs.items()
    }
    return ErrorNetwork(tuple(steps), ranges, outputs, angles, formats, proven)


def _sizes(enclosures: Sequence[Interval | None], turns: Sequence[bool]) -> list[float]:
    pairs = zip(enclosures, turns, strict=True)
    return [each.magnitude if each is not None and free else 0.0 for each, free in pairs]


def _operand(arithmetic: Arithmetic, operand: Operand, number: Fraction | None) -> str | Constant:
    if operand.value is not None:
        return operand.value
    assert operand.constant is not None
    assert number is not None
    return _constant(arithmetic, operand.constant, number)


def _constant(arithmetic: Arithmetic, text: str, number: Fraction) -> Constant:
    word = Fraction(float(arithmetic.system.constant(text).values))
    error = abs(word - number)
    near = float(number)
    interval = Interval(near, near)
    if Fraction(near) != number:
        interval = Interval(math.nextafter(near, -math.inf), math.nextafter(near, math.inf))
    return Constant(interval, math.nextafter(float(error), math.inf) if error else 0.0)


def _whole_turns(graph: Graph, angles: Mapping[str, bool]) -> set[Value]:
    """Return the values that may change by a whole turn without any difference to an output.

    Those taken only by angles among the outputs, by the angle of a circular rotation, and by sums and
    integer multiples of which the same holds.
    """
    taken: dict[Value, bool] = {}

    def take(value: Value, free: bool) -> None:
        taken[value] = taken.get(value, True) and free

    for name, value in graph.outputs.items():
        take(value, angles[name])
    for index in reversed(range(len(graph.nodes))):
        node = graph.nodes[index]
        free = taken.get(Value(index, node.definition.angle or 0), False)
        for port, value in enumerate(node.operands):
            match node.op:
                case "rotate":
                    take(value, node.m == 1 and port == 2)
                case "vector":
                    take(value, port == 2 and free)
                case "add" | "sub" | "neg":
                    take(value, free)
                case "wrap":
                    take(value, True)
                case "cmul":
                    take(value, free and node.factor.denominator == 1)
                case "shift":
                    take(value, free and node.exponent >= 0)
                case "guard":
                    take(value, free and port == 0)
                case "select":
                    take(value, free and port > 0)
                case _:
                    take(value, False)
    return {value for value, free in taken.items() if free}


def _turned(graph: Graph) -> set[Value]:
    """Return the values that may be enclosed a turn off: angles of vectors, and what is made of them."""
    found: set[Value] = set()
    for index, node in enumerate(graph.nodes):
        result = node.definition.angle or 0
        circular = angle_result(node.op, node.definition.named(node.params)) is not None or node.op == "wrap"
        if circular or (node.op in _OF_ANGLES and not found.isdisjoint(node.operands)):
            found.add(Value(index, result))
    return found


_OF_ANGLES = ("add", "sub", "neg", "cmul", "shift", "guard", "select", "vector")
"""Operations that make an angle of one."""


def rounding(format_: NumberFormat, magnitude: Floats, beside_pi: Any = False) -> Floats:
    """Return the largest error of rounding numbers of a magnitude to words that hold them.

    An angle beside pi goes to the last word before it.
    """
    if isinstance(format_, FixedPoint):
        places = 1.0 if format_.rounding == "floor" else 0.5
        return np.where(beside_pi, 1.25, places) * format_.ulp + np.zeros_like(magnitude)
    return magnitude * np.where(beside_pi, 2.0**-22, 2.0**-24) + 2.0**-149


_PASSED_ON = ("neg", "abs", "sign", "min", "max", "flip", "select", "guard")
"""Operations that make no other number than an operand, its negative, or its sign."""


def _exact(arithmetic: Arithmetic, formats: PortFormats, operation: Operation) -> bool:
    """Tell whether the first result of an operation needs no rounding to its format."""
    result = formats.values[operation.results[0]] if operation.results[0] is not None else None

    def fraction(operand: Operand) -> int:
        format_ = _format(arithmetic, formats, operand)
        assert isinstance(format_, FixedPoint)
        return format_.fraction_bits

    if not isinstance(result, FixedPoint):
        return operation.op in _PASSED_ON  # to the one format that there is
    if operation.op == "wrap":
        return False
    first, *others = (fraction(operand) for operand in operation.operands)
    match operation.op:
        case "mul":
            first += others[0]
        case "cmul":
            first += fraction(Operand(constant=str(operation.params["factor"])))
        case "shift":
            first -= int(operation.params["exponent"])
        case "add" | "sub" | "min" | "max":
            first = max(first, *others)
        case "select":
            first = max(others)
        case "sign":
            first = 0
    return first <= result.fraction_bits


def _quarters(arithmetic: Arithmetic, formats: PortFormats, operation: Operation) -> QuarterTurns | None:
    if operation.op != "rotate" or operation.m != 1:
        return None
    return arithmetic.quarters(operation.kind, _format(arithmetic, formats, operation.operands[2]))


def _least(arithmetic: Arithmetic, formats: PortFormats, operation: Operation) -> int:
    if operation.op != "rotate" or operation.m != 1:
        return ZERO_EXPONENT
    x, y = (_format(arithmetic, formats, operand) for operand in operation.operands[:2])
    return least_exponent(x, y, arithmetic.caus[operation.kind].operand_bits)


def _format(arithmetic: Arithmetic, formats: PortFormats, operand: Operand) -> NumberFormat:
    if operand.constant is not None:
        return arithmetic.system.constant(operand.constant).format
    assert operand.value is not None
    return formats.values[operand.value]


def _spacing(formats: PortFormats, operation: Operation) -> float:
    first = operation.operands[0].value
    format_ = None if first is None else formats.values[first]
    return format_.ulp if isinstance(format_, FixedPoint) else 0.0
