"""What the operations of a plan compute, as formulas in the names of the problem."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from cordicc.plan import Operand, Operation, Plan
from cordicc.targets.model import CAU_KINDS

LONGEST = 72
"""Characters of a formula; what would make it longer keeps a name of its own."""

_SUM, _MINUS, _PRODUCT, _ATOM = 1, 2, 3, 4
"""How firmly a formula binds: a sum, a minus in front of a product or atom, a product, an atom."""

_FLOAT_DIGITS = 6

Formula = tuple[str, int]
"""A text and how firmly it binds."""


class Formulas:
    """Writes the values of a plan; small operators are written out, results of CAUs have names.

    A result that is an output has the output's name, one that is an output but for its wrapping the name
    with a prime, another its own, such as `o3.norm`.
    """

    def __init__(self, plan: Plan) -> None:
        self._maker = {name: o for o in plan.operations for name in o.results if name is not None}
        self._named = _names(plan, self._maker)
        self._inputs = {str(item["name"]) for item in plan.problem["inputs"]}
        self._made: dict[str, Formula] = {}
        self.left: list[str] = []
        """The values that formulas so far name without being results of CAUs, for a list of their own."""

    def name(self, value: str) -> str:
        """Return how a value is called."""
        return self._named.get(value, value)

    def operand(self, item: Operand) -> str:
        """Return an operand, written out as far as it stays short."""
        return self._operand(item)[0]

    def value(self, value: str) -> str:
        """Return the formula of a small operator's result, its operands written out."""
        return self._written(self._maker[value])[0]

    def _operand(self, item: Operand) -> Formula:
        if item.value is None:
            return _number(str(item.constant))
        maker = self._maker.get(item.value)
        if maker is None or maker.kind in CAU_KINDS:
            return self.name(item.value), _ATOM
        if item.value not in self._made:
            written = self._written(maker)
            if len(written[0]) > LONGEST // 2:
                self.left.append(item.value)
                written = self.name(item.value), _ATOM
            self._made[item.value] = written
        return self._made[item.value]

    def _written(self, operation: Operation) -> Formula:
        operands = [self._operand(item) for item in operation.operands]
        return _WRITERS[operation.op](operands, operation.params)

    def unit(self, operation: Operation) -> list[str]:
        """Return what an operation of a CAU does: a line for each result that is used."""
        operands = [self._operand(item) for item in operation.operands]
        texts = _UNIT_WRITERS[operation.op](operands, operation.params)
        return [
            f"{self.name(name)} = {text}"
            for name, text in zip(operation.results, texts, strict=True)
            if name is not None
        ]


def _names(plan: Plan, maker: Mapping[str, Operation]) -> dict[str, str]:
    names: dict[str, str] = {}
    for output, operand in plan.outputs.items():
        if operand.value is None:
            continue
        names.setdefault(operand.value, output)
        operation = maker.get(operand.value)
        if operation is not None and operation.op == "wrap" and operation.operands[0].value is not None:
            names.setdefault(operation.operands[0].value, output + "'")
    return {value: name for value, name in names.items() if value in maker}


def _number(text: str) -> Formula:
    number = float(Fraction(text)) if "/" in text else float(text)
    shown = f"{number:.{_FLOAT_DIGITS}g}"
    return shown, _MINUS if shown.startswith("-") else _ATOM


def _at(formula: Formula, level: int) -> str:
    text, binds = formula
    return text if binds >= level else f"({text})"


def _add(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    a, b = operands
    if a[1] == _MINUS and b[1] != _MINUS:
        a, b = b, a
    return f"{a[0]} {_signed(b, 1)}", _SUM


def _sub(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    a, b = operands
    return f"{a[0]} {_signed(b, -1)}", _SUM


def _signed(term: Formula, sign: int) -> str:
    """Return a term with its sign in front."""
    if term[1] == _MINUS:
        return f"{'-' if sign > 0 else '+'} {term[0][1:]}"
    return f"+ {term[0]}" if sign > 0 else f"- {_at(term, _PRODUCT)}"


def _mul(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    a, b = operands
    if a == b:
        return f"{_at(a, _ATOM)}^2", _PRODUCT
    return f"{_at(a, _PRODUCT)} {_at(b, _PRODUCT)}", _PRODUCT


def _cmul(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    factor, _ = _number(str(params["factor"]))
    level = _MINUS if factor.startswith("-") else _PRODUCT
    if operands[0][1] == _PRODUCT and operands[0][0][0].isdigit():
        return f"{factor} ({operands[0][0]})", level
    return f"{factor} {_at(operands[0], _PRODUCT)}", level


def _shift(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    exponent = int(str(params["exponent"]))
    sign = f"2^{exponent}" if abs(exponent) > 1 else ("2" if exponent == 1 else "0.5")
    return f"{sign} {_at(operands[0], _PRODUCT)}", _PRODUCT


def _neg(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    return f"-{_at(operands[0], _PRODUCT)}", _MINUS


def _guarded(operands: Sequence[Formula], params: Mapping[str, object]) -> Formula:
    a, s = operands
    return f"valid({a[0]} if {s[0]} is {params['condition']})", _ATOM


def _called(name: str) -> Callable[[Sequence[Formula], Mapping[str, object]], Formula]:
    return lambda operands, params: (f"{name}({', '.join(text for text, _ in operands)})", _ATOM)


_WRITERS: dict[str, Callable[[Sequence[Formula], Mapping[str, object]], Formula]] = {
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "cmul": _cmul,
    "shift": _shift,
    "neg": _neg,
    "guard": _guarded,
    "abs": _called("abs"),
    "sign": _called("sign"),
    "min": _called("min"),
    "max": _called("max"),
    "flip": lambda operands, params: (f"({operands[0][0]} with the sign of {operands[1][0]})", _ATOM),
    "select": lambda operands, params: (
        f"({operands[1][0]} if {operands[0][0]} >= 0 else {operands[2][0]})",
        _ATOM,
    ),
    "wrap": _called("wrap"),
}


def _joined(z: Formula, sign: str, angle: str) -> str:
    """Return z plus or minus an angle; a z of 0 says nothing."""
    if z[0] in ("0", "-0"):
        return angle if sign == "+" else f"-{angle}"
    return f"{z[0]} {sign} {angle}"


def _vector(operands: Sequence[Formula], params: Mapping[str, object]) -> list[str]:
    x, y, z = operands
    sign = "+" if params["sign"] == 1 else "-"
    if params["m"] == 1:
        return [f"length of ({x[0]}, {y[0]})", _joined(z, sign, f"atan2({y[0]}, {x[0]})")]
    quotient = f"{_at(y, _PRODUCT)} / {_at(x, _ATOM)}"
    if params["m"] == 0:
        return [x[0], _joined(z, sign, quotient)]
    root = f"sqrt({_at(x, _ATOM)}^2 - {_at(y, _ATOM)}^2)"
    return [root, _joined(z, sign, f"atanh({quotient})")]


def _rotate(operands: Sequence[Formula], params: Mapping[str, object]) -> list[str]:
    x, y, z = operands
    if params["m"] == 0:
        product = f"{_at(x, _PRODUCT)} {_at(z, _PRODUCT)}"
        return [x[0], product if y[0] in ("0", "-0") else f"{y[0]} + {product}"]
    functions = ("cos", "sin") if params["m"] == 1 else ("cosh", "sinh")
    if y[0] in ("0", "-0"):
        factor = "" if x[0] == "1" else f"{_at(x, _PRODUCT)} "
        return [f"{factor}{function}({z[0]})" for function in functions]
    how = "turned by" if params["m"] == 1 else "turned hyperbolically by"
    return [f"{axis} of ({x[0]}, {y[0]}) {how} {z[0]}" for axis in "xy"]


def _lightcone(operands: Sequence[Formula], params: Mapping[str, object]) -> list[str]:
    u, v = operands
    if v[0] == "1":
        return [f"sqrt({u[0]})", f"0.5 log({u[0]})"]
    return [
        f"sqrt({_at(u, _PRODUCT)} {_at(v, _PRODUCT)})",
        f"0.5 log({_at(u, _PRODUCT)} / {_at(v, _ATOM)})",
    ]


def _implicit(operands: Sequence[Formula], params: Mapping[str, object]) -> list[str]:
    functions = ("cos", "sin") if params["m"] == 1 else ("cosh", "sinh")
    a, b, c = operands
    terms = [
        _signed(
            (f"{text} {function}(t)" if text not in ("1", "-1") else f"{text[:-1]}{function}(t)", level), 1
        )
        if level != _SUM
        else f"+ ({text}) {function}(t)"
        for (text, level), function in zip((b, a), functions, strict=True)
        if text not in ("0", "-0")
    ]
    left = re.sub(r"^\+ |^(-) ", r"\1", " ".join(terms)) or "0"
    branch = "" if params["branch"] == "none" else f", branch {params['branch']}"
    minus = "-" if params["m"] == 1 else "+"
    squares = [f"{_at(each, _ATOM)}^2" for each in (a, b, c)]
    inner = f"{squares[0]} + {squares[1]} - {squares[2]}"
    if params["m"] == -1:
        inner = f"{squares[0]} - {squares[1]} {minus} {squares[2]}"
    return [f"t with {left} = {c[0]}{branch}", f"sqrt({inner})"]


_UNIT_WRITERS: dict[str, Callable[[Sequence[Formula], Mapping[str, object]], list[str]]] = {
    "vector": _vector,
    "rotate": _rotate,
    "lightcone": _lightcone,
    "implicit": _implicit,
}
