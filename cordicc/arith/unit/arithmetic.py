"""The arithmetic of a target: every operation of a plan executed on words, bit for bit.

An arithmetic is built from plain data (embedded in every plan):

    format: {kind: ieee-single}     # or {kind: fixed-point, width: 24, guard: 4, rounding: half-up}
    units:
      standard: {mantissa_bits: 32, exponent_bits: 10, angle_bits: 32, iterations: 30}
      implicit: {mantissa_bits: 32, exponent_bits: 10, angle_bits: 32, iterations: 30, rule: single-rotation}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cordicc.arith.kernels.blocks import ZERO_EXPONENT
from cordicc.arith.kernels.reduction import QuarterTurns, quarter_turns
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import NumberFormat, NumberSystem, Signal
from cordicc.arith.numbers.slack import slack_of
from cordicc.arith.unit.cau import EXPONENT_BITS, INTEGER_BITS, Cau
from cordicc.base.arrays import Floats

RULES = ("single-rotation", "root-free")
"""Implicit rules: standard micro-rotations with the target scaled by their gain, or root-free ones."""

_MOST_MANTISSA_BITS = 40 + INTEGER_BITS
_MOST_ANGLE_BITS = 44
_FEWEST_ITERATIONS = 4

_SYSTEM_KEYS = {"ieee-single": (set(), set()), "fixed-point": ({"width"}, {"guard", "rounding"})}
"""Of a number system by its kind: keys that must be there and that may be."""


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """A number system and the CAUs by kind, and the plain data that they were built from."""

    system: NumberSystem
    caus: Mapping[str, Cau]
    spec: Mapping[str, Any]

    @classmethod
    def from_spec(cls, spec: Mapping[str, Any]) -> Arithmetic:
        """Build from plain data, see the module.  Raises ValueError with what is wrong."""
        _keys(spec, "arithmetic", {"format", "units"}, set())
        system = system_from_spec(spec["format"])
        if not isinstance(spec["units"], Mapping):
            raise ValueError("arithmetic.units must be a mapping of kinds")
        units = spec["units"].items()
        caus = {str(kind): _cau(str(kind), unit, system.operand_bits) for kind, unit in units}
        return cls(system, caus, spec)

    def execute(
        self,
        op: str,
        params: Mapping[str, Any],
        kind: str,
        operands: Sequence[Signal],
        formats: Sequence[NumberFormat | None],
        angle: int | None,
    ) -> tuple[Signal | None, ...]:
        """Execute an operation on words.

        Args:
            op: an arithmetic or unit operation.
            params: its parameters; a factor is the text of a constant.  A `slack` besides tells what counts
                as on the border of the domain.
            kind: the kind of the executing unit, which picks the CAU.
            operands: arrays of words, shape (n,) or broadcastable to it.
            formats: of each result, None for one that nobody takes.
            angle: the number of the result that is an angle in radians, which no word takes beyond pi.

        Returns:
            Each result, None where nobody takes it.  Any invalid operand makes every result invalid.

        Raises:
            ValueError: unknown operation, parameter or kind.
        """
        if op in _UNIT_OPERATIONS:
            if kind not in self.caus:
                raise ValueError(f"the target has no arithmetic for units of kind {kind!r}")
            values = [operand.values for operand in operands]
            more: dict[str, Any] = {}
            if op == "rotate":
                least = least_exponent(operands[0].format, operands[1].format, self.caus[kind].operand_bits)
                more = {"quarters": self.quarters(kind, operands[2].format), "least": least}
            results = _UNIT_OPERATIONS[op](self.caus[kind], params, *values, **more)
            return tuple(
                None if f is None else Signal(f.encode_angle(v) if at == angle else f.encode(v), f)
                for at, (v, f) in enumerate(zip(results, formats, strict=True))
            )
        (result,) = formats
        if result is None:
            return (None,)
        return (Signal(self.system.calculate(op, params, operands, result), result),)

    def quarters(self, kind: str, angle: NumberFormat) -> QuarterTurns | None:
        """Return the table by which a circular rotation on a kind of unit reduces angles of a format.

        None where it reduces them by a product: words that float, and those that hold many quarter turns.
        """
        if not isinstance(angle, FixedPoint):
            return None
        return quarter_turns(self.caus[kind].angle_bits, angle.width_bits, angle.fraction_bits)


def least_exponent(x: NumberFormat, y: NumberFormat, operand_bits: int) -> int:
    """Return the exponent of the largest words of two formats as mantissas, that of 0 of words that float."""
    if not isinstance(x, FixedPoint) or not isinstance(y, FixedPoint):
        return ZERO_EXPONENT
    return max(each.width_bits - 1 - each.fraction_bits for each in (x, y)) - operand_bits


_UNIT_OPERATIONS: dict[str, Callable[..., tuple[Floats, ...]]] = {
    "rotate": lambda cau, params, *values, **more: cau.rotate(_system(params), *values, **more),
    "vector": lambda cau, params, *values: cau.vector(
        _system(params), _unit_sign(params), *values, slack=slack_of(params)
    ),
    "lightcone": lambda cau, params, *values: cau.lightcone(*values, slack=slack_of(params)),
    "implicit": lambda cau, params, *values: cau.implicit(
        _system(params), _branch(params), *values, slack=slack_of(params)
    ),
}


def _system(params: Mapping[str, Any]) -> int:
    if params.get("m") not in (1, 0, -1):
        raise ValueError(f"the coordinate system m must be 1, 0 or -1, not {params.get('m')!r}")
    return int(params["m"])


def _unit_sign(params: Mapping[str, Any]) -> int:
    if params.get("sign") not in (1, -1):
        raise ValueError(f"the sign must be 1 or -1, not {params.get('sign')!r}")
    return int(params["sign"])


def _branch(params: Mapping[str, Any]) -> str:
    allowed = ("+", "-") if params.get("m") == 1 else ("+", "-", "none")
    if params.get("m") == 0 or params.get("branch") not in allowed:
        raise ValueError(f"no implicit mode with m {params.get('m')!r}, branch {params.get('branch')!r}")
    return str(params["branch"])


def _cau(kind: str, spec: Any, operand_bits: int) -> Cau:
    where = f"arithmetic.units.{kind}"
    _keys(spec, where, {"mantissa_bits", "exponent_bits", "iterations"}, {"angle_bits", "rule"})
    least = operand_bits + INTEGER_BITS
    mantissa = _integer(spec, where, "mantissa_bits", range(least, _MOST_MANTISSA_BITS + 1))
    _integer(spec, where, "exponent_bits", range(EXPONENT_BITS, EXPONENT_BITS + 1))
    iterations = _integer(spec, where, "iterations", range(_FEWEST_ITERATIONS, mantissa))
    angle = mantissa
    if "angle_bits" in spec:
        angle = _integer(spec, where, "angle_bits", range(operand_bits, _MOST_ANGLE_BITS + 1))
    rule = spec.get("rule")
    if "rule" in spec and rule not in RULES:
        raise ValueError(f"{where}.rule must be one of {', '.join(RULES)}")
    return Cau(mantissa - INTEGER_BITS, iterations, rule, operand_bits, angle)


def system_from_spec(spec: Mapping[str, Any]) -> NumberSystem:
    """Build a number system from its plain-data form.  Raises ValueError."""
    kind = spec.get("kind") if isinstance(spec, Mapping) else None
    if not isinstance(kind, str) or kind not in _SYSTEM_KEYS:
        raise ValueError(f"the number format needs a 'kind' (known: {', '.join(_SYSTEM_KEYS)})")
    required, optional = _SYSTEM_KEYS[kind]
    keys = set(spec) - {"kind"}
    if missing := sorted(required - keys):
        raise ValueError(f"the number format {kind} lacks {', '.join(missing)}")
    if unknown := sorted(str(key) for key in keys - required - optional):
        raise ValueError(f"the number format {kind} has unknown keys: {', '.join(unknown)}")
    if kind == "ieee-single":
        return SingleSystem()
    width, guard = spec["width"], spec.get("guard", 0)
    if type(width) is not int or type(guard) is not int:
        raise ValueError("the widths of a number format are integers")
    return FixedSystem(width, guard, spec.get("rounding", "half-up"))


def _integer(spec: Mapping[str, Any], where: str, key: str, allowed: range) -> int:
    value = spec[key]
    if not isinstance(value, int) or isinstance(value, bool) or value not in allowed:
        raise ValueError(f"{where}.{key} must be an integer from {allowed.start} to {allowed.stop - 1}")
    return value


def _keys(spec: Any, where: str, required: set[str], optional: set[str]) -> None:
    if not isinstance(spec, Mapping):
        raise ValueError(f"{where} must be a mapping")
    if missing := sorted(required - set(spec)):
        raise ValueError(f"{where} lacks {', '.join(missing)}")
    if unknown := sorted(str(key) for key in set(spec) - required - optional):
        raise ValueError(f"{where} has unknown keys: {', '.join(unknown)}")
