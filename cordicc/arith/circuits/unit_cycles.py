"""How many cycles a unit takes at a clock: those of its circuit, for operations that stand for any."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cordicc.arith.circuits.cell_delays import Clocking
from cordicc.arith.circuits.looping import too_fast
from cordicc.arith.circuits.units import Plain, unit_builder
from cordicc.arith.circuits.uses import Use
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.slack import Slack
from cordicc.arith.unit.arithmetic import Arithmetic

_SYSTEMS = {"circular": 1, "linear": 0, "hyperbolic": -1}

_PARAMETERS: Mapping[str, tuple[tuple[str, object], ...]] = {
    # Two thirds of a power of two: as many digits as a number can have.
    "cmul": (("factor", "0.66666666666666666"),),
    "shift": (("exponent", 1),),
    "guard": (("condition", "nonnegative"),),
}

_OPERANDS = {"cmul": 1, "shift": 1, "neg": 1, "abs": 1, "sign": 1, "wrap": 1, "select": 3}


def cycles_at(
    arithmetic: Arithmetic, kind: str, functions: Sequence[str], clocking: Clocking, interval: int = 1
) -> int:
    """Return the cycles of a unit that does some functions, each on words with a binary point of its own.

    Args:
        arithmetic: on fixed point, with the sizes of the unit.
        kind: of unit.
        functions: by the names of a target file.
        clocking: the period and the delays.
        interval: cycles from one operation to the next.

    Raises:
        ValueError: a step that is made again and again takes longer than the period.
    """
    system = arithmetic.system
    assert isinstance(system, FixedSystem)
    width = system.operand_bits
    uses = [_use(function, width, number) for number, function in enumerate(functions)]
    made = unit_builder(kind, arithmetic, kind, uses, clocking, interval)
    if too_fast(made):
        most = 1e3 / (made.step_ns + clocking.delays.register_ns)
        raise ValueError(
            f"an iteration of a unit of kind '{kind}' takes {made.step_ns:.1f} ns: one a cycle is for "
            f"clocks of at most {most:.0f} MHz"
        )
    return max(1, made.cycles())


def _use(function: str, width: int, number: int) -> Use | Plain:
    # Angles reach pi; functions that share a unit seldom have one binary point.
    fraction = width - 3 - number % 2
    word, finer = FixedPoint(width, fraction), FixedPoint(width, fraction + 1)
    op, _, system = function.partition("-")
    if system or op == "lightcone":
        m = _SYSTEMS.get(system, -1)
        operands = (word,) * (2 if op == "lightcone" else 3)
        # Rounded operands stand on the border of a domain if they are as near as they were rounded.
        slack = Slack(word.ulp, word.ulp) if m == -1 or op == "implicit" else Slack(0.0, 0.0)
        return Use(op, m, operands, (word, word), angle={"vector": 1, "implicit": 0}.get(op), slack=slack)
    operands = (word, finer, word)[: _OPERANDS.get(op, 2)]
    return Plain(op, _PARAMETERS.get(op, ()), operands, word)
