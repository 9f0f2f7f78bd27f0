"""Outputs that are computed alike from other inputs, such as those of copies: one proof does for all."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

from cordicc.certify.certificate import Bound
from cordicc.certify.error_network import Constant, ErrorNetwork, Step
from cordicc.certify.predicates import OWN_BOUND, margin


@dataclass(frozen=True, slots=True)
class Twins:
    """By output, the one that stands for it, and what stands for each step in its network by id."""

    of: Mapping[str, str]
    steps: Mapping[str, Mapping[str, Step]]

    def representatives(self, net: ErrorNetwork) -> ErrorNetwork:
        """Return the network of the outputs that stand for themselves, or the network if all do."""
        kept = [name for name in net.outputs if self.of[name] == name]
        if len(kept) == len(net.outputs):
            return net
        wanted = {step.id for name in kept for step in net.upstream(name)}
        steps = tuple(step for step in net.steps if step.id in wanted)
        needed = net.needed(steps, [net.outputs[name] for name in kept]) or set(net.inputs)
        return replace(
            net,
            steps=steps,
            inputs={name: interval for name, interval in net.inputs.items() if name in needed},
            outputs={name: net.outputs[name] for name in kept},
        )

    def bound(self, output: str, bounds: Mapping[str, Bound]) -> Bound:
        """Return the bound of an output, its conditions on the output's own operations."""
        bound = bounds[self.of[output]]
        if self.of[output] == output:
            return bound
        own = self.steps[output]
        where = (
            p if p.kind == OWN_BOUND or p.operation is None else margin(own[p.operation], p.threshold)
            for p in bound.where
        )
        return replace(bound, where=tuple(where))


def twins(net: ErrorNetwork, wanted: Mapping[str, float]) -> Twins:
    """Return which outputs differ in names alone: operations, formats, ranges and proven values are equal.

    `wanted` is by output the bound that suffices, equal for twins too.
    """
    first: dict[Hashable, str] = {}
    of: dict[str, str] = {}
    steps: dict[str, dict[str, Step]] = {}
    for output in net.outputs:
        upstream = net.upstream(output)
        other = first.setdefault((wanted.get(output), _form(net, output, upstream)), output)
        of[output] = other
        steps[output] = {a.id: b for a, b in zip(net.upstream(other), upstream, strict=True)}
    return Twins(of, steps)


def _form(net: ErrorNetwork, output: str, upstream: Sequence[Step]) -> Hashable:
    """Return all that a bound of an output depends on, with numbers for names."""
    numbers: dict[str, int] = {}
    inputs: list[Hashable] = []

    def operand(name: str | Constant) -> Hashable:
        if isinstance(name, Constant):
            return name
        if name not in numbers:
            numbers[name] = len(numbers)
            inputs.append((net.inputs[name], repr(net.formats.values[name])))
        return numbers[name]

    form: list[Hashable] = []
    for step in upstream:
        taken = tuple(operand(each) for each in step.operands)
        made = tuple(name is not None and net.proven.get(name, True) for name in step.results)
        for name in step.results:
            if name is not None:
                numbers[name] = len(numbers)
        known = replace(step, id="", equation="", params={}, operands=(), results=(), cau=None)
        params = tuple(sorted((name, repr(value)) for name, value in step.params.items()))
        form.append((repr(known), params, id(step.cau), taken, made))
    last = operand(net.outputs[output])
    return tuple(form), tuple(inputs), last, net.angles[output], repr(net.formats.outputs[output])
