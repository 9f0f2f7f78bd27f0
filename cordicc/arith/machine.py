"""The arithmetic of a target: every operation of a plan executed on words, bit for bit.

An arithmetic is built from plain data (embedded in every plan):

    format: {kind: ieee-single}
    units:
      standard: {mantissa_bits: 32, exponent_bits: 10, iterations: 30}
      implicit: {mantissa_bits: 32, exponent_bits: 10, iterations: 30, rule: single-rotation}
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.blocks import unpack
from cordicc.arith.cau import Cau
from cordicc.arith.formats import FloatArray, NumberFormat, Word, format_from_spec
from cordicc.arith.reduction import phase_in_turns

RULES = ("single-rotation", "root-free")
"""Implicit rules: standard micro-rotations with the target scaled by their gain, or root-free ones."""

_INTEGER_BITS = 3
_MANTISSA_BITS = range(24, 33)
_EXPONENT_BITS = 10


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """A number format and the CAUs by kind."""

    format: NumberFormat
    caus: Mapping[str, Cau]

    @classmethod
    def from_spec(cls, spec: Mapping[str, Any]) -> Arithmetic:
        """Build from plain data, see the module.  Raises ValueError with what is wrong."""
        _keys(spec, "arithmetic", {"format", "units"}, set())
        format_ = format_from_spec(spec["format"])
        if not isinstance(spec["units"], Mapping):
            raise ValueError("arithmetic.units must be a mapping of kinds")
        return cls(
            format_, {str(kind): _cau(str(kind), unit, format_) for kind, unit in spec["units"].items()}
        )

    def execute(
        self, op: str, params: Mapping[str, object], kind: str, operands: Sequence[Word]
    ) -> tuple[Word, ...]:
        """Execute an operation on words.

        Args:
            op: an arithmetic or unit operation.
            params: its parameters; a factor is a Fraction or the text of a constant.
            kind: the kind of the executing unit, which picks the CAU.
            operands: arrays of words, shape (n,) or broadcastable to it.

        Returns:
            One array a result.  Any invalid operand makes every result invalid.

        Raises:
            ValueError: unknown operation, parameter or kind.
        """
        if op in _UNIT_OPERATIONS:
            if kind not in self.caus:
                raise ValueError(f"the target has no arithmetic for units of kind {kind!r}")
            return _UNIT_OPERATIONS[op](self.caus[kind], params, *operands)
        if op not in _OPERATIONS:
            raise ValueError(f"unknown operation {op!r}")
        values = [self.format.decode(word) for word in operands]
        if op == "wrap":
            return (np.asarray(self.format.encode_angle(wrapped(values[0]))),)
        parameters = dict(params)
        if op == "cmul":
            parameters["factor"] = self.format.decode(self._factor(params["factor"]))
        with np.errstate(invalid="ignore", over="ignore", under="ignore"):
            result = _OPERATIONS[op](parameters, *values)
        invalid: NDArray[np.bool_] = np.isnan(values[0])
        for value in values[1:]:
            invalid = invalid | np.isnan(value)
        return (np.asarray(self.format.encode(np.where(invalid, np.nan, result))),)

    def _factor(self, factor: object) -> Word:
        if isinstance(factor, str):
            return self.format.parse_constant(factor)
        if isinstance(factor, (Fraction, int)):
            return self.format.constant(Fraction(factor))
        raise ValueError(f"a factor must be a rational or its text, not {type(factor).__name__}")


def wrapped(angle: FloatArray) -> FloatArray:
    """Return an angle in radians modulo 2 pi, in [-pi, pi] as float64.

    Exact but for 2^-59 rad up to 2^24 rad (2 pi in two parts, the product with the first exact), and
    for 2^-38 rad beyond (phase modulo 2^64).
    """
    with np.errstate(invalid="ignore"):
        turns = np.rint(angle / math.tau)
        near = np.abs(angle) <= 2.0**24
        turns = np.where(near, turns, 0.0)
        result = (angle - turns * _TAU_HEAD) - turns * _TAU_TAIL
    far = ~near & np.isfinite(angle)
    if far.any():
        result = result.copy()
        result[far] = phase_in_turns(unpack(angle[far])) * math.tau
    return np.asarray(result)


_TAU_HEAD = math.floor(math.tau * 2**26) / 2**26
_TAU_TAIL = (math.tau - _TAU_HEAD) + 2.4492935982947064e-16  # 2 pi - float(2 pi), correctly rounded


def _cmul(params: Mapping[str, Any], a: FloatArray) -> FloatArray:
    return np.asarray(a * params["factor"])


def _shift(params: Mapping[str, Any], a: FloatArray) -> FloatArray:
    return np.asarray(np.ldexp(a, max(-2000, min(2000, int(params["exponent"])))))


def _chosen(s: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    return np.where(s >= 0, a, b)


def _guard(params: Mapping[str, Any], a: FloatArray, s: FloatArray) -> FloatArray:
    condition = params["condition"]
    if condition not in _CONDITIONS:
        raise ValueError(f"unknown guard condition {condition!r}")
    return np.where(_CONDITIONS[condition](s), a, np.nan)


_CONDITIONS: dict[object, Callable[[FloatArray], NDArray[np.bool_]]] = {
    "any": lambda s: np.ones(s.shape, dtype=bool),
    "nonzero": lambda s: s != 0,
    "nonnegative": lambda s: s >= 0,
    "positive": lambda s: s > 0,
}

# Sums and products of two 24-bit numbers, rounded to 53 bits and then to 24, are as if rounded once.
_OPERATIONS: dict[str, Callable[..., FloatArray]] = {
    "add": lambda params, a, b: a + b,
    "sub": lambda params, a, b: a - b,
    "mul": lambda params, a, b: a * b,
    "cmul": _cmul,
    "shift": _shift,
    "neg": lambda params, a: -a,
    "abs": lambda params, a: np.abs(a),
    "sign": lambda params, a: np.sign(a),
    "min": lambda params, a, b: np.minimum(a, b),
    "max": lambda params, a, b: np.maximum(a, b),
    "flip": lambda params, a, s: _chosen(s, a, -a),
    "select": lambda params, s, a, b: _chosen(s, a, b),
    "guard": _guard,
    "wrap": lambda params, a: wrapped(a),
}

_UNIT_OPERATIONS: dict[str, Callable[..., tuple[Word, ...]]] = {
    "rotate": lambda cau, params, *words: cau.rotate(_system(params), *words),
    "vector": lambda cau, params, *words: cau.vector(_system(params), _unit_sign(params), *words),
    "lightcone": lambda cau, params, *words: cau.lightcone(*words),
    "implicit": lambda cau, params, *words: cau.implicit(_system(params), _branch(params), *words),
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


def _cau(kind: str, spec: Any, format_: NumberFormat) -> Cau:
    where = f"arithmetic.units.{kind}"
    _keys(spec, where, {"mantissa_bits", "exponent_bits", "iterations"}, {"rule"})
    mantissa = _integer(spec, where, "mantissa_bits", _MANTISSA_BITS)
    _integer(spec, where, "exponent_bits", range(_EXPONENT_BITS, _EXPONENT_BITS + 1))
    iterations = _integer(spec, where, "iterations", range(16, mantissa))
    rule = spec.get("rule")
    if rule is not None and rule not in RULES:
        raise ValueError(f"{where}.rule must be one of {', '.join(RULES)}")
    return Cau(mantissa - _INTEGER_BITS, iterations, rule, format_)


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
