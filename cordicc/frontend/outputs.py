"""The outputs of a file: which names they are, which of them are angles, and their options."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from heapq import heappop, heappush

from cordicc.frontend.document.yamltree import NodeKind, Places, YamlNode
from cordicc.frontend.lower import emit
from cordicc.frontend.plain.define import Defined
from cordicc.frontend.reading import check_keys, read_boolean, read_constant, read_mapping, wanted
from cordicc.frontend.scope import MAX_ERRORS, Scope, did_you_mean
from cordicc.ir.graph import Value
from cordicc.ir.problem import OutputSpec

_MAX_SHOWN = 120


class OutputReader:
    """Reads the section `outputs`, given what the equations define."""

    def __init__(self, scope: Scope, places: Places, defined: Defined) -> None:
        self.scope = scope
        self.places = places
        self.defined = defined
        self.report = scope.report
        self._angles = _Angles(defined)

    def read(self, node: YamlNode | None) -> tuple[tuple[OutputSpec, ...], dict[str, Value]]:
        """Return the outputs, and their values by name; without a section, what no equation uses."""
        listed: list[tuple[str, YamlNode | None, YamlNode | None]]
        if node is None or node.is_null:
            used = {name for target, uses in self.defined.uses.items() for name in uses if name != target}
            used = self.defined.with_siblings(used)
            listed = [(name, None, None) for name in self.defined.uses if name not in used]
        else:
            variants = self.defined.variants
            listed = [
                (name, key, options)
                for key, options in self._listed(node)
                for name in variants.get(key.value, [key.value])
            ]
        specs: dict[str, OutputSpec] = {}
        values: dict[str, Value] = {}
        for name, key, options in listed:
            if self.report.errors >= MAX_ERRORS:
                break
            if key is not None and not self._is_output(name, key, specs):
                continue
            spec = self._read_one(name, options)
            specs[name] = spec
            value = self.scope.values.get(name)
            if value is not None:
                self.scope.builder.origin = name
                values[name] = emit(self.scope.builder, "wrap", [value]) if spec.wrap else value
        return tuple(specs.values()), values

    def _listed(self, node: YamlNode) -> list[tuple[YamlNode, YamlNode | None]]:
        if node.kind is NodeKind.SCALAR:
            hint = "write '[name, name]'"
            self.report.error("E202", wanted("'outputs'", "a list or a mapping", node), node.span, hint)
            return []
        if node.size == 1:
            self.report.error("E208", "there are no outputs", node.span)
        if node.kind is NodeKind.MAPPING:
            return list(node.pairs)
        found: list[tuple[YamlNode, YamlNode | None]] = []
        for item in node.items:
            if item.kind is NodeKind.SCALAR and not item.is_null:
                found.append((item, None))
            else:
                hint = self._mapping_form(node)
                self.report.error("E202", wanted("an output", "a name", item), item.span, hint)
        return found

    def _is_output(self, name: str, key: YamlNode, specs: Mapping[str, OutputSpec]) -> bool:
        if name in specs:
            self.report.error("E214", f"the output '{name}' is listed twice", key.span)
            return False
        if name in self.defined.uses:
            return True
        members = self.defined.members.get(name)
        if members:
            hint = f"'{name}' has several values: list those wanted of {', '.join(members)}"
        elif name in self.scope.lines:
            hint = f"only what an equation defines can be an output: write one such as '{name}_out = {name}'"
        else:
            hint = did_you_mean(name, self.defined.uses) or "no equation defines that name"
        if name not in self.scope.later:
            self.report.error("E213", f"unknown output '{name[:60]}'", key.span, hint)
        return False

    def _read_one(self, name: str, options: YamlNode | None) -> OutputSpec:
        is_angle = self._angles.has(name)
        wrap, max_error = True, None
        if options is not None:
            form = "write '{max_error: 1e-5}' or '{wrap: false}'"
            read_mapping(options, f"the options of '{name}'", form, self.report)
            entries = check_keys(options, ("max_error", "wrap"), self.report)
            wrap_node, error_node = entries.get("wrap"), entries.get("max_error")
            if wrap_node is not None:
                wrap = read_boolean(wrap_node, "'wrap'", self.report) is not False
                if not is_angle and name in self.defined.forms and self.scope.values.get(name) is not None:
                    message = f"'{name}' is not an angle: 'wrap' has no effect"
                    self.report.warning("W104", message, wrap_node.span)
            if error_node is not None:
                max_error = read_constant(error_node, "'max_error'", self.scope, self.places)
                if max_error is not None and max_error <= 0:
                    self.report.error("E215", "'max_error' must be greater than 0", error_node.span)
        return OutputSpec(name, is_angle, is_angle and wrap, max_error)

    def _mapping_form(self, node: YamlNode) -> str:
        """Return the hint that shows a list of outputs with options as a mapping."""
        parts: dict[str, str] = {}
        for item in node.items:
            if item.kind is NodeKind.SCALAR and not item.is_null:
                parts.setdefault(item.value, "")
            parts |= {key.value: self._flow(value) for key, value in item.pairs}
        shown = "outputs: {" + ", ".join(f"{name}: {options}" for name, options in parts.items()) + "}"
        if len(shown) > _MAX_SHOWN or not any(parts.values()):
            shown = "outputs: {name: {max_error: 1e-5}}"
        return f"options need the form '{shown}'"

    def _flow(self, node: YamlNode) -> str:
        """Return the text of a node in one line."""
        if node.kind is NodeKind.MAPPING:
            return "{" + ", ".join(f"{key.value}: {self._flow(value)}" for key, value in node.pairs) + "}"
        if node.kind is NodeKind.SEQUENCE:
            return "[" + ", ".join(map(self._flow, node.items)) + "]"
        return " ".join(self.places.text[node.start : node.end].split())


class _Angles:
    """Tells of names whether an integer multiple of an inverse circular function takes part in them."""

    def __init__(self, defined: Defined) -> None:
        self._order = defined.order
        self._targets = defined.targets
        self._forms = defined.forms
        self._ends: dict[str, tuple[str, Fraction]] = {}
        for target in defined.targets:
            self._ends[target] = self._end(target)

    def _end(self, target: str) -> tuple[str, Fraction]:
        """Return the name of which `target` is a multiple as far as angles go, and the multiple."""
        form = self._forms[target]
        used = [(name, k) for name, k in form.names.items() if k and self._bears(name)]
        if form.angles or len(used) != 1 or used[0][0] not in self._ends:
            return target, Fraction(1)
        name, k = used[0]
        end, multiple = self._ends[name]
        return end, k * multiple

    def _bears(self, name: str) -> bool:
        """Return whether an angle takes part in a name at all."""
        if name not in self._ends:
            return False
        form = self._forms[self._ends[name][0]]
        return bool(form.angles or form.names)

    def has(self, output: str) -> bool:
        """Return whether an integer multiple of an angle takes part in the output."""
        order, forms = self._order, self._forms
        multiples: dict[str, Fraction] = {}
        todo: list[int] = []

        def reach(name: str, factor: Fraction) -> None:
            if name not in self._ends:
                return
            end, multiple = self._ends[name]
            if end not in multiples:
                heappush(todo, -order[end])
            multiples[end] = multiples.get(end, Fraction(0)) + factor * multiple

        reach(output, Fraction(1))
        while todo:
            target = self._targets[-heappop(todo)]
            multiple = multiples.pop(target)
            if any(k * multiple and (k * multiple).denominator == 1 for k in forms[target].angles):
                return True
            for name, k in forms[target].names.items():
                reach(name, k * multiple)
        return False
