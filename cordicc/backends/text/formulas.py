"""What each operation of a plan computes, as formulas in the inputs and in what the CAUs deliver."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from cordicc.backends.labels import constant
from cordicc.backends.text import mathml
from cordicc.backends.text.mathml import Formula
from cordicc.plan.model import Operand, Operation, Plan, dependence_order
from cordicc.targets.target import CAU_KINDS

MOST_PARTS, MOST_SHARED_PARTS = 5, 3
"""Operations that one formula is put together from; larger parts are named by their operation, and so are
smaller ones that several operations take."""

CONDITIONS = {"nonzero": "≠ 0", "nonnegative": "≥ 0", "positive": "> 0", "any": "has a value"}

_ZERO, _ONE, _TWO = (mathml.number(n) for n in (0, 1, 2))


class Formulas:
    """The formulas of a plan's values and operations."""

    def __init__(self, plan: Plan) -> None:
        made = {name for o in plan.operations for name in o.results}
        self._names = {i.value: name for name, i in reversed(list(plan.outputs.items())) if i.value in made}
        self._inline: dict[str, tuple[Formula, int]] = {}
        self._results: dict[str, tuple[Formula, ...]] = {}
        taken = Counter(item.value for o in plan.operations for item in o.operands)
        self._most = {name: MOST_SHARED_PARTS if taken[name] > 1 else MOST_PARTS for name in taken if name}
        self._single = {name for o in plan.operations for name in o.results if name and len(o.results) == 1}
        for operation in dependence_order(plan):
            self._add(operation)

    def symbol(self, value: str) -> Formula:
        """Return the sign of a value: an input, an output, or an operation with its result as an index."""
        if value in self._names:
            return mathml.name(self._names[value])
        operation, dot, port = value.partition(".")
        if not dot:
            return mathml.name(value)
        return mathml.indexed(operation, "" if value in self._single else port)

    def operand(self, item: Operand) -> Formula:
        """Return what a port takes, written out as far as it is short."""
        if item.value is None:
            return mathml.number(constant(str(item.constant)).replace("−", "-"))
        return self._inline[item.value][0] if item.value in self._inline else self.symbol(item.value)

    def of(self, operation: Operation) -> tuple[Formula, ...]:
        """Return an equation for each result that is used, of an implicit CAU the equation that it solves."""
        return self._results[operation.id]

    def written_out(self, value: str) -> bool:
        """Tell whether a value stands for what it is made of in the formulas of what takes it."""
        return value in self._inline

    def _add(self, operation: Operation) -> None:
        operands = [self.operand(item) for item in operation.operands]
        names = [None if name is None else self.symbol(name) for name in operation.results]
        write = WRITERS.get(operation.op)
        if write is None or len(operands) != len(operation.ports):
            listed = mathml.call(operation.op, operands)
            self._results[operation.id] = tuple(_is(name, listed) for name in names if name)
            return
        right = write(operation, operands, names)
        self._results[operation.id] = tuple(made for made in right if made is not None)
        if operation.op in _INLINE and names[0] is not None and operation.kind not in CAU_KINDS:
            parts = 1 + sum(self._inline.get(item.value or "", (_ZERO, 0))[1] for item in operation.operands)
            result = str(operation.results[0])
            if parts <= self._most.get(result, 0):
                self._inline[result] = _INLINE[operation.op](operation, operands), parts


Names = Sequence[Formula | None]
Equations = Sequence[Formula | None]


def _is(name: Formula, right: Formula) -> Formula:
    return mathml.relation(name, "=", right)


def plus(*terms: Formula) -> Formula:
    """Return a sum without its zeros."""
    kept = [term for term in terms if not term.is_zero]
    return mathml.total(kept, [1] * len(kept)) if kept else _ZERO


def minus(first: Formula, second: Formula) -> Formula:
    """Return a difference, without zeros."""
    if second.is_zero:
        return first
    return mathml.negative(second) if first.is_zero else mathml.total([first, second], [1, -1])


def times(*factors: Formula) -> Formula:
    """Return a product without its ones; 0 if a factor is."""
    if any(factor.is_zero for factor in factors):
        return _ZERO
    kept = [factor for factor in factors if not factor.is_one]
    negatives = sum(factor.negated is not None for factor in kept) % 2
    plain = [factor.negated or factor for factor in kept]
    # The brackets of a product of products say nothing.
    plain = [_loose(factor) for factor in plain if not factor.is_one]
    result = mathml.product(plain) if plain else _ONE
    return mathml.negative(result) if negatives else result


def _loose(factor: Formula) -> Formula:
    return replace(factor, binding=mathml.POWER) if factor.binding == mathml.PRODUCT else factor


def square(base: Formula) -> Formula:
    """Return a square."""
    return base if base.is_zero or base.is_one else mathml.power(base.negated or base, _TWO)


def _number_of(operation: Operation, name: str) -> Formula:
    return mathml.number(constant(str(operation.params.get(name, ""))).replace("−", "-"))


def _shifted(operation: Operation, operands: Sequence[Formula]) -> Formula:
    exponent = int(operation.params.get("exponent", 0))
    if abs(exponent) <= 4:
        factor = mathml.number(str(2**exponent) if exponent >= 0 else f"1/{2**-exponent}")
    else:
        factor = mathml.power(_TWO, mathml.number(exponent))
    return times(factor, operands[0])


def _product(operation: Operation, operands: Sequence[Formula]) -> Formula:
    first, second = operands
    return square(first) if first == second else times(first, second)


_INLINE: dict[str, Callable[[Operation, Sequence[Formula]], Formula]] = {
    "add": lambda o, w: plus(*w),
    "sub": lambda o, w: minus(*w),
    "mul": _product,
    "cmul": lambda o, w: times(_number_of(o, "factor"), w[0]),
    "shift": _shifted,
    "neg": lambda o, w: mathml.negative(w[0]),
    "abs": lambda o, w: mathml.call("abs", w),
    "sign": lambda o, w: mathml.call("sign", w),
    "min": lambda o, w: mathml.call("min", w),
    "max": lambda o, w: mathml.call("max", w),
}
"""The arithmetic that is written out in the formulas of what follows it."""


def _arithmetic(operation: Operation, operands: Sequence[Formula], names: Names) -> Equations:
    if names[0] is None:
        return ()
    return (_is(names[0], _INLINE[operation.op](operation, operands)),)


def _worded(write: Callable[[Operation, Sequence[Formula]], Sequence[Formula]]) -> Writer:
    """Return the writer of an operation that takes a few words."""

    def written(operation: Operation, operands: Sequence[Formula], names: Names) -> Equations:
        return () if names[0] is None else (_is(names[0], mathml.sequence(write(operation, operands))),)

    return written


Writer = Callable[[Operation, Sequence[Formula], Names], Equations]


def _rotate(operation: Operation, operands: Sequence[Formula], names: Names) -> Equations:
    x, y, z = operands
    m = operation.m
    if m == 0:
        right = (x, plus(y, times(x, z)))
    else:
        c, s = (mathml.call(f, [z]) for f in (("cos", "sin") if m == 1 else ("cosh", "sinh")))
        second = times(y, s)
        right = (
            minus(times(x, c), second) if m == 1 else plus(times(x, c), second),
            plus(times(y, c), times(x, s)),
        )
    return tuple(_is(name, value) for name, value in zip(names, right, strict=True) if name)


def _vector(operation: Operation, operands: Sequence[Formula], names: Names) -> Equations:
    x, y, z = operands
    m = operation.m
    if m == 0:
        norm, angle = x, mathml.quotient(y, x)
    elif m == 1:
        norm, angle = mathml.root(plus(square(x), square(y))), mathml.call("atan2", [y, x])
    else:
        norm = mathml.root(minus(square(x), square(y)))
        angle = mathml.call("atanh", [mathml.quotient(y, x)])
    turned = plus(z, angle) if operation.params.get("sign") == 1 else minus(z, angle)
    return tuple(_is(name, value) for name, value in zip(names, (norm, turned), strict=True) if name)


def _lightcone(operation: Operation, operands: Sequence[Formula], names: Names) -> Equations:
    u, v = operands
    half = times(mathml.quotient(_ONE, _TWO), mathml.call("log", [mathml.quotient(u, v)]))
    right = (mathml.root(times(u, v)), half)
    return tuple(_is(name, value) for name, value in zip(names, right, strict=True) if name)


def _implicit(operation: Operation, operands: Sequence[Formula], names: Names) -> Equations:
    A, B, C = operands
    m = operation.m
    angle = names[0] or mathml.name("theta")
    c, s = (mathml.call(f, [angle]) for f in (("cos", "sin") if m == 1 else ("cosh", "sinh")))
    solved = mathml.relation(plus(times(B, c), times(A, s)), "=", C)
    if names[1] is None:
        return (solved,)
    squares = plus(square(A), square(B)) if m == 1 else minus(square(A), square(B))
    rest = minus(squares, square(C)) if m == 1 else plus(squares, square(C))
    return (solved, _is(names[1], mathml.root(rest)))


_TURN = times(_TWO, mathml.name("pi"))


def _wrap(operation: Operation, operands: Sequence[Formula]) -> Sequence[Formula]:
    return operands[0].within(mathml.PRODUCT), mathml.words(" modulo "), _TURN


def _flip(operation: Operation, operands: Sequence[Formula]) -> Sequence[Formula]:
    a, s = operands
    return a, mathml.words(" if "), s, mathml.words(" ≥ 0, else "), mathml.negative(a)


def _select(operation: Operation, operands: Sequence[Formula]) -> Sequence[Formula]:
    s, a, b = operands
    return a, mathml.words(" if "), s, mathml.words(" ≥ 0, else "), b


def _guard(operation: Operation, operands: Sequence[Formula]) -> Sequence[Formula]:
    condition = str(operation.params.get("condition", ""))
    a, s = operands
    return a, mathml.words(", valid if "), s, mathml.words(f" {CONDITIONS.get(condition, condition)}")


WRITERS: dict[str, Writer] = {
    **dict.fromkeys(_INLINE, _arithmetic),
    "rotate": _rotate,
    "vector": _vector,
    "lightcone": _lightcone,
    "implicit": _implicit,
    "wrap": _worded(_wrap),
    "flip": _worded(_flip),
    "select": _worded(_select),
    "guard": _worded(_guard),
}
