"""Results of operations as elements of the field, and the operands that make them long."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from cordicc.ir.graph import Node, Value
from cordicc.rewrite.exact.angle_rotors import Rotors
from cordicc.rewrite.exact.constants import Constants
from cordicc.rewrite.exact.field import Element, monic
from cordicc.rewrite.exact.known_values import KnownValues
from cordicc.rewrite.exact.radicands import square_root, under_root
from cordicc.rewrite.exact.signs import Signs, never_negative

_LONG = 8
"""Terms of the longest elements that are not worth a generator of their own."""

_LINEAR = ("add", "sub", "neg", "cmul", "shift")


class ElementFinder:
    """Finds elements from those of the operands; `values` are the values that generators stand for."""

    def __init__(self, constants: Constants, rotors: Rotors, signs: Signs, known: KnownValues) -> None:
        self._constants, self._rotors, self._signs, self._known = constants, rotors, signs, known
        self._field = constants.field
        self._sign_elements: dict[str, Element] = {}
        self.values: dict[int, Value] = {}

    def elements(self, index: int) -> tuple[Element | None, ...]:
        """Return the results of a node as elements, None for those that are none.

        Raises:
            TooLarge: they outgrow the work that is spent on them.
            ZeroDivisionError: a divisor is 0.
        """
        field, node = self._field, self._known.node(Value(index))
        width = len(node.definition.results)
        if node.op == "input":
            return (self.free(Value(index)),)
        if node.op == "const":
            return (self._constants.number(node.number),)
        if node.op in ("min", "max", "select", "sign"):
            return (self.free(Value(index)),)
        given = [self._known.element(v) for v in node.operands]
        if node.op == "rotate" and node.m != 0:
            m = node.m
            rotor = self._rotors.rotor(node.operands[2], m)
            if given[0] is None or given[1] is None or rotor is None:
                return (None, None)
            return self._rotors.turn((given[0], given[1]), rotor, m)
        if node.op == "vector" and node.m != 0:
            given[2] = field.number(Fraction(0))
        operands = [e for e in given if e is not None]
        if len(operands) < len(given):
            return (None,) * width
        match node.op:
            case "add":
                return (field.add(*operands),)
            case "sub":
                return (field.sub(*operands),)
            case "mul":
                return (field.mul(*operands),)
            case "cmul":
                return (field.mul(self._constants.number(node.factor), operands[0]),)
            case "shift":
                exponent = node.exponent
                if exponent.denominator != 1:
                    return (None,)
                return (field.scale(Fraction(2) ** int(exponent), operands[0]),)
            case "neg":
                return (field.scale(Fraction(-1), operands[0]),)
            case "abs":
                return (field.mul(self._sign_element(node.operands[0]), operands[0]),)
            case "flip":
                return (field.mul(self._sign_element(node.operands[1]), operands[0]),)
            case "guard":
                return (operands[0],)
            case "vector":
                return self._vector_elements(node, operands)
            case "rotate":
                x, y, z = operands
                return x, field.add(y, field.mul(x, z))
            case "lightcone":
                return square_root(self._known, under_root(field, node, operands)), None
            case "implicit":
                return None, square_root(self._known, under_root(field, node, operands))
        return (None,) * width

    def free(self, value: Value) -> Element:
        """Return a new generator that stands for a value.  Raises TooLarge."""
        index = self._field.free()
        self.values[index] = value
        return Element(self._field.generator(index), self._field.one)

    def _vector_elements(self, node: Node, operands: Sequence[Element]) -> tuple[Element | None, ...]:
        field, (x, y, z) = self._field, operands
        m, sign = node.m, node.sign
        if m == 0:
            quotient = field.div(y, x)
            return x, field.add(z, field.scale(Fraction(sign), quotient))
        squares = under_root(field, node, operands)
        if m == 1:
            self._signs.know(squares, 1, int(all(self._known.is_total(v) for v in node.operands[:2])))
        return square_root(self._known, squares), None

    def _sign_element(self, value: Value) -> Element:
        """Return 1 or -1 where the sign is known, else a generator with square 1."""
        interval = self._known.range(value)
        if never_negative(self._known, value):
            return self._field.number(Fraction(1))
        if interval is not None and interval.hi < 0:
            return self._field.number(Fraction(-1))
        element = self._known.element(value)
        assert element is not None
        factor, base = monic(element.num)
        key = f"{factor > 0}{base}/{element.den}"
        if key not in self._sign_elements:
            self._sign_elements[key] = Element(self._field.generator(self._field.sign()), self._field.one)
        return self._sign_elements[key]


def long_parts(known: KnownValues, index: int) -> set[Value]:
    """Return long factors of products that a node adds up, or its long operands."""

    def is_long(value: Value) -> bool:
        element = known.element(value)
        return element is not None and len(element.num) + len(element.den) > _LONG

    node = known.node(Value(index))
    found: set[Value] = set()
    todo = [Value(index)] if node.op in (*_LINEAR, "mul") else list(node.operands)
    while todo:
        inner = known.node(todo.pop())
        if inner.op in _LINEAR:
            todo += inner.operands
        elif inner.op == "mul":
            todo += [v for v in inner.operands if known.node(v).op == "mul"]
            found |= {v for v in inner.operands if known.node(v).op != "mul" and is_long(v)}
    return found or {v for v in node.operands if is_long(v)}
