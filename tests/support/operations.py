"""Every operation of the table with parameters of every kind."""

from fractions import Fraction

from cordicc.ir.graph import Builder, Graph, Param, Value
from cordicc.ir.ops import OPS, Level

_PARAMS: dict[str, list[tuple[Param, ...]]] = {
    "input": [("x0",)],
    "const": [(Fraction(5, 7),)],
    "cmul": [(Fraction(-3, 7),)],
    "shift": [(Fraction(-2),), (Fraction(3),)],
    "pow": [(Fraction(n, 2),) for n in (-5, -2, 1, 3, 4)],
    "guard": [(c,) for c in ("any", "nonzero", "nonnegative", "positive")],
    "solve": [(1, "+"), (1, "-"), (-1, "+"), (-1, "-"), (-1, "none")],
    "rotate": [(1,), (0,), (-1,)],
    "vector": [(m, sign) for m in (1, 0, -1) for sign in (1, -1)],
    "implicit": [(1, "+"), (1, "-"), (-1, "+"), (-1, "-"), (-1, "none")],
}

Case = tuple[str, tuple[Param, ...]]


def cases(*levels: Level) -> list[Case]:
    """Return every operation of these vocabularies, once for each choice of its parameters."""
    return [
        (name, params)
        for name, definition in OPS.items()
        if definition.level in levels
        for params in _PARAMS.get(name, [()])
    ]


def graph_of(op: str, params: tuple[Param, ...] = ()) -> Graph:
    """Return a graph of inputs x0, x1 ..., one operation on them, and its results as outputs r0, r1 ..."""
    builder = Builder()
    made = builder.emit(op, [builder.input(f"x{i}") for i in range(OPS[op].arity)], params)
    return builder.build({f"r{i}": Value(made.node, i) for i in range(len(OPS[op].results))})


def plan_params(op: str, params: tuple[Param, ...]) -> dict[str, int | str]:
    """Return parameters as a plan has them, by name: a factor is a text, an exponent of a shift whole."""
    named = OPS[op].named(params)
    return {
        name: f"{float(param)!r}" if name == "factor" else int(param) if op == "shift" else param
        for name, param in named.items()
    }
