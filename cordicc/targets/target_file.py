"""Target files: YAML, read and checked, with what they leave open filled in."""

from __future__ import annotations

import os
from collections.abc import Callable, Set
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import MappingNode, ScalarNode

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Report, Source, Span
from cordicc.targets.device import DEVICES, Device
from cordicc.targets.sized import WEIGHTS, guard_is_open, sized
from cordicc.targets.target import CAU_KINDS, FUNCTIONS_OF_KIND, Target, UnitKind

REQUIRED_KINDS = ("standard", "add", "mul", "cmul", "shift", "sign")

_SIZE_LIMIT_BYTES = 256 * 1024
_LATENCY_LIMIT = 100_000
_LARGEST_NUMBER = 1e12
_MOST_ERRORS = 50
_LONGEST_NAME, _LONGEST_DESCRIPTION = 200, 2_000


@dataclass(frozen=True, slots=True)
class Asked:
    """What a user asks for instead of what a target says: bits of the words outside, the clock in hertz."""

    width_bits: int | None = None
    clock_hz: float | None = None

    def instead(self, data: dict[Any, Any]) -> dict[Any, Any]:
        """Return the data of a target with it."""
        if self.width_bits is not None:
            data = {**data, "format": {**data["format"], "width": self.width_bits}}
        return data if self.clock_hz is None else {**data, "clock_hz": self.clock_hz}


AS_WRITTEN = Asked()
"""Nothing."""


def shipped_targets() -> tuple[str, ...]:
    """Return the names of the targets in the package."""
    files = resources.files("cordicc.targets").iterdir()
    return tuple(sorted(f.name.removesuffix(".yaml") for f in files if f.name.endswith(".yaml")))


def target_text(name_or_path: str | os.PathLike[str]) -> Source:
    """Return the text of a shipped target or of a file.  Raises InvalidInput (E501, E502)."""
    name = os.fspath(name_or_path)
    if name in shipped_targets():
        text = resources.files("cordicc.targets").joinpath(f"{name}.yaml").read_text(encoding="utf-8")
        return Source(f"{name}.yaml", text)
    report = Report(Source(name, ""))
    path = Path(name)
    try:
        exists = path.is_file()
    except (OSError, ValueError):
        exists = False
    if not exists:
        known = ", ".join(shipped_targets())
        report.error("E501", f"no target '{name}'", hint=f"shipped targets: {known}; or give a YAML file")
        report.raise_if_failed()
    try:
        with path.open("rb") as file:
            data = file.read(_SIZE_LIMIT_BYTES + 1)
        if len(data) > _SIZE_LIMIT_BYTES:
            report.error("E502", f"the file is larger than {_SIZE_LIMIT_BYTES // 1024} KiB")
        text = data.decode("utf-8")
    except OSError as error:
        report.error("E502", f"cannot read the file: {error.strerror or 'input error'}")
    except UnicodeDecodeError:
        report.error("E502", "the file is not UTF-8 text")
    report.raise_if_failed()
    return Source(name, text)


def load_target(
    name_or_path: str | os.PathLike[str],
    guard_bits: int = 0,
    width_bits: int | None = None,
    used: Set[str] | None = None,
    *,
    alone: bool = False,
    asked: Asked = AS_WRITTEN,
) -> Target:
    """Load and validate a shipped target by name, or a file.

    Args:
        name_or_path: of a shipped target, or of a file.
        guard_bits: of values between operations, where the target leaves them open.
        width_bits: of words outside instead of the target's own, where it leaves the guard bits open.
        used: functions that the sizes of units follow from where the target leaves them open; None: all.
        alone: whether a unit does one function each, as at an interval of 1, and has the latency of that.
        asked: what is asked for instead of the target's own width and clock.

    Raises:
        InvalidInput: E501 to E505, or a width for words that are not fixed point (E506).
    """
    source = target_text(name_or_path)
    report = Report(source)
    try:
        data = _loaded(source.text)
    except (YAMLError, ValueError, RecursionError, TypeError, AttributeError, LookupError) as error:
        mark = getattr(error, "problem_mark", None)
        span = None if mark is None else Span(mark.line + 1, mark.column + 1, mark.column + 2)
        problem = getattr(error, "problem", None) or "it cannot be read"
        raise _failure(report, "E503", f"not valid YAML: {problem}", span) from None
    if not isinstance(data, dict):
        raise _failure(report, "E503", "a target must be a mapping")
    if asked.width_bits is not None and not _is_fixed_point(data):
        message = f"a width of {asked.width_bits} bits is for fixed-point words, which this target has not"
        hint = "--target fixed24, or leave out --width"
        raise InvalidInput([Diagnostic("E506", message, None, hint, source=source)])
    data = asked.instead(data)
    try:
        filled = sized(data, guard_bits, width_bits, used, alone=alone)
        target = _Reader(report, cache(lambda: _yaml().compose(source.text))).target(filled)
        report.raise_if_failed()
        assert target is not None
        target.machine()
    except ValueError as error:
        raise _failure(report, "E505", str(error)) from None
    # A unit that several functions share has one latency.
    units = target.units if alone else {kind: replace(u, latencies={}) for kind, u in target.units.items()}
    return replace(target, units=units, guard_is_open=guard_is_open(data))


def _is_fixed_point(data: dict[Any, Any]) -> bool:
    format_ = data.get("format")
    return isinstance(format_, dict) and format_.get("kind") == "fixed-point"


def _yaml() -> YAML:
    yaml = YAML(typ="safe", pure=True)
    yaml.version = "1.2"
    return yaml


@lru_cache(maxsize=16)
def _loaded(text: str) -> Any:
    """Return the data of a target file, which stays as it is: a plan asks for one target many times."""
    return _yaml().load(text)


def _failure(report: Report, code: str, message: str, span: Span | None = None) -> InvalidInput:
    report.error(code, message, span)
    return InvalidInput(report.ordered())


def _span(root: Any, place: str) -> Span | None:
    """Return where the value at a place such as `units.mul.area` stands, else what encloses it."""
    node, found = root, None
    for part in place.split(".") if place else ():
        pairs = node.value if isinstance(node, MappingNode) else []
        pair = next((p for p in pairs if isinstance(p[0], ScalarNode) and p[0].value == part), None)
        if pair is None:
            break
        key, node = pair
        scalar = isinstance(node, ScalarNode) and node.start_mark.line == node.end_mark.line
        found = node if scalar and node.end_mark.column > node.start_mark.column else key
    if found is None:
        return None
    start, end = found.start_mark, found.end_mark
    return Span(start.line + 1, start.column + 1, end.column + 1)


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the mapping of a target, recording everything that is wrong (E504)."""

    report: Report
    root: Callable[[], Any]

    def target(self, data: dict[Any, Any]) -> Target | None:
        required = {"name", "clock_hz", "format", "units"}
        optional = {"description", "angle_unit", "fifo_area_per_bit", "device", "weights"}
        self._keys(data, "", required, optional)
        name = self._text(data, "name", _LONGEST_NAME)
        description = self._text(data, "description", _LONGEST_DESCRIPTION)
        clock_hz = self._number(data, "clock_hz", "", 1.0, least=1.0)
        area_per_bit = self._number(data, "fifo_area_per_bit", "", 0.0)
        angle_unit = data.get("angle_unit", "rad")
        if angle_unit not in ("rad", "turn"):
            self._error("angle_unit must be 'rad' or 'turn'", "angle_unit")
        elif angle_unit == "turn":
            self._error("angle_unit 'turn' is not supported yet: plans compute in radians", "angle_unit")
        device = self._device(data)
        weights = self._weights(data)
        number_format = self._mapping(data, "format", "")
        units = self._units(self._mapping(data, "units", ""))
        if self.report.failed:
            return None
        return Target(
            name,
            description,
            clock_hz,
            angle_unit,
            number_format,
            area_per_bit,
            units,
            device=device,
            weights=weights,
        )

    def _device(self, data: dict[Any, Any]) -> Device | None:
        name = data.get("device")
        if name is not None and (not isinstance(name, str) or name not in DEVICES):
            self._error(f"device must be one of {', '.join(DEVICES)}", "device")
            return None
        return None if name is None else DEVICES[name]

    def _weights(self, data: dict[Any, Any]) -> dict[str, float]:
        if "weights" not in data:
            return {}
        weights = self._mapping(data, "weights", "")
        self._keys(weights, "weights.", set(WEIGHTS), set())
        return {name: self._number(weights, name, "weights.", 0.0) for name in WEIGHTS}

    def _units(self, data: dict[Any, Any]) -> dict[str, UnitKind]:
        for kind in REQUIRED_KINDS:
            if kind not in data:
                self._error(f"units lacks the kind '{kind}'", "units")
        units = {}
        for kind, unit in data.items():
            if kind not in FUNCTIONS_OF_KIND:
                known = ", ".join(FUNCTIONS_OF_KIND)
                self._error(f"unknown unit kind '{_shown(kind)}' (known: {known})", f"units.{kind}")
            elif not isinstance(unit, dict):
                self._error(f"units.{kind} must be a mapping", f"units.{kind}")
            else:
                units[kind] = self._unit(kind, unit)
        return units

    def _unit(self, kind: str, data: dict[Any, Any]) -> UnitKind:
        where = f"units.{kind}."
        required = {"latency", "functions", "area"} | ({"arithmetic"} if kind in CAU_KINDS else set())
        self._keys(data, where, required, {"initiation_interval", "adders", "stages", "latencies"})
        fewest = 0 if kind in ("sign", "shift") else 1
        latency = self._integer(data, "latency", where, 1, least=fewest)
        latencies = self._mapping(data, "latencies", where) if "latencies" in data else {}
        alone = {
            str(function): self._integer(latencies, function, f"{where}latencies.", 1, least=fewest)
            for function in latencies
        }
        for function in sorted(set(alone) - FUNCTIONS_OF_KIND[kind]):
            self._error(
                f"{where}latencies: '{_shown(function)}' is no function of a unit of kind '{kind}'", where
            )
        interval = self._integer(data, "initiation_interval", where, 1, least=1)
        adders = self._integer(data, "adders", where, 0, least=0)
        area = self._number(data, "area", where, 0.0)
        functions = data.get("functions", [])
        if not isinstance(functions, list) or not all(isinstance(f, str) for f in functions):
            self._error(f"{where}functions must be a list of names", f"{where}functions")
            functions = []
        for function in functions:
            if function not in FUNCTIONS_OF_KIND[kind]:
                known = ", ".join(sorted(FUNCTIONS_OF_KIND[kind]))
                self._error(
                    f"{where}functions: a unit of kind '{kind}' "
                    f"cannot do '{_shown(function)}' (but: {known})",
                    f"{where}functions",
                )
        if not functions and "functions" in data:
            self._error(f"{where}functions is empty", f"{where}functions")
        stages = self._mapping(data, "stages", where) if "stages" in data else {}
        cycles = [self._integer(stages, part, f"{where}stages.", 1, least=1) for part in stages]
        if "stages" in data and not self.report.failed and sum(cycles) != latency:
            message = f"{where}stages sum to {sum(cycles)} cycles, but the latency is {latency}"
            self._error(message, f"{where}latency")
        arithmetic = self._mapping(data, "arithmetic", where) if kind in CAU_KINDS else None
        if kind == "implicit" and arithmetic is not None and "rule" not in arithmetic:
            self._error(f"{where}arithmetic lacks the rule", f"{where}arithmetic")
        if kind == "standard" and arithmetic is not None and "rule" in arithmetic:
            self._error(f"{where}arithmetic has a rule, which implicit units have", f"{where}arithmetic")
        named = {str(part): count for part, count in zip(stages, cycles, strict=True)}
        return UnitKind(kind, latency, interval, frozenset(functions), adders, area, named, arithmetic, alone)

    def _error(self, message: str, place: str) -> None:
        if len(self.report.diagnostics) < _MOST_ERRORS:
            self.report.error("E504", message, _span(self.root(), place))

    def _keys(self, data: dict[Any, Any], where: str, required: set[str], optional: set[str]) -> None:
        name = where.rstrip(".") or "the target"
        for key in sorted(required - set(data)):
            self._error(f"{name} lacks '{key}'", where.rstrip("."))
        for key in sorted(str(key) for key in data if key not in required | optional):
            self._error(f"{name} has an unknown key '{_shown(key)}'", where + key)

    def _mapping(self, data: dict[Any, Any], key: str, where: str) -> dict[Any, Any]:
        value = data.get(key, {})
        if isinstance(value, dict):
            return value
        self._error(f"{where}{key} must be a mapping", where + key)
        return {}

    def _text(self, data: dict[Any, Any], key: str, longest: int) -> str:
        value = data.get(key, "")
        if not isinstance(value, str) or len(value) > longest:
            what = "text" if not isinstance(value, str) else f"no longer than {longest} characters"
            self._error(f"{key} must be {what}", key)
            return ""
        return value

    def _integer(self, data: dict[Any, Any], key: str, where: str, default: int, *, least: int) -> int:
        value = data.get(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= _LATENCY_LIMIT:
            message = f"{where}{_shown(key)} must be an integer from {least} to {_LATENCY_LIMIT}"
            self._error(message, f"{where}{key}")
            return default
        return value

    def _number(
        self, data: dict[Any, Any], key: str, where: str, default: float, *, least: float = 0.0
    ) -> float:
        value = data.get(key, default)
        good = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not good or not least <= value <= _LARGEST_NUMBER:
            limits = f"from {least:g} to {_LARGEST_NUMBER:g}"
            self._error(f"{where}{key} must be a number {limits}", where + key)
            return default
        return float(value)


def _shown(key: object) -> str:
    """Return a key of the file, shortened if need be."""
    text = str(key)
    return text if len(text) <= 40 else f"{text[:40]}..."
