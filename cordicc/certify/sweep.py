"""Bounds of an output's error over many boxes of inputs at once, by interval derivatives.

Let every operation k of the plan compute f_k(operands) + e_k, inputs and constants included. The output is
a function F(e_1, e_2, ...) of these errors, exact for 0, computed for their real values. By the mean value
theorem along the line between,

    computed - exact = sum over k of e_k dF/de_k,

the derivatives at one place of the line. The forward sweep encloses all values that occur on such lines over
a box, the backward sweep the derivatives there; where an error reaches the output on several ways their
derivatives add up before absolute values are taken.

`moved` bounds how far a value moves along a line. A threshold says that only lines count along which the
margin of an operation is at least that. Boxes in which no valid sample has such a line are empty.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.formats import NumberFormat
from cordicc.base.arrays import Bools, Floats
from cordicc.certify.boxes import Boxes, point, times, up
from cordicc.certify.error_network import Constant, ErrorNetwork, Step, rounding
from cordicc.certify.operator_models import CHOOSER, local, margin_slopes, margin_square
from cordicc.certify.unit_models import Local


@dataclass(slots=True)
class Forward:
    """What the forward sweep has found: boxes and movement by name, operations by id, empty boxes.

    `empties` are the boxes that each operation, by its id, shows to be empty.
    """

    count: int
    values: dict[str, Boxes]
    moved: dict[str, Floats]
    locals: dict[str, Local]
    squares: dict[str, Boxes]
    empties: dict[str, Bools]
    exact: bool
    limited: bool
    jumps: bool = True

    def empty(self, steps: Sequence[Step]) -> Bools:
        """Return the boxes that some operations show to be empty."""
        found = np.zeros(self.count, dtype=bool)
        for step in steps:
            if step.id in self.empties:
                found |= self.empties[step.id]
        return found

    def mark(self, step: Step, boxes: Bools) -> None:
        """Note that an operation shows some boxes to be empty."""
        known = self.empties.get(step.id)
        self.empties[step.id] = boxes if known is None else known | boxes

    def operand(self, operand: str | Constant) -> tuple[Boxes, Floats]:
        """Return the box of an operand and how far it moves."""
        if isinstance(operand, Constant):
            exact = operand.interval
            error = 0.0 if self.exact else operand.error
            box = Boxes(np.full(self.count, exact.lo), np.full(self.count, exact.hi))
            return (box.widened(error) if error else box), np.full(self.count, error)
        return self.values[operand], self.moved[operand]


def forward(
    net: ErrorNetwork,
    steps: Sequence[Step],
    boxes: Mapping[str, Boxes],
    thresholds: Mapping[str, float],
    *,
    exact: bool = False,
    limited: bool = True,
    jumps: bool = True,
) -> Forward:
    """Enclose the values of some steps over boxes of inputs.

    Args:
        net: the network.
        steps: of it, in order, all that they depend on included.
        boxes: by input, of equal length.
        thresholds: by id of an operation, the least margin.
        exact: enclose the values without errors.
        limited: use what holds for valid samples only: formats and proven ranges.
        jumps: count what changes where an error makes an operation choose otherwise.
    """
    count = len(next(iter(boxes.values())).lo)
    made = Forward(count, {}, {}, {}, {}, {}, exact, limited, jumps)
    for name, box in boxes.items():
        error = np.zeros(count) if exact else rounding(net.formats.values[name], box.magnitude)
        made.values[name], made.moved[name] = box.widened(error), error
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):  # of unbounded intervals
        for step in steps:
            _advance(net, step, thresholds.get(step.id, 0.0), made)
    return made


def _advance(net: ErrorNetwork, step: Step, threshold: float, made: Forward) -> None:
    operands, moved = zip(*(made.operand(operand) for operand in step.operands), strict=True)
    square = margin_square(step, operands)
    if square is not None:
        made.squares[step.id] = square
        least = threshold * threshold
        made.mark(step, square.hi < least)
        low = np.maximum(square.lo, least * (1 - 2.0**-50))
        square = Boxes(low, np.maximum(square.hi, low))
    found = local(step, operands, square, moved)
    made.locals[step.id] = found
    for result, name in enumerate(step.results):
        if name is None:
            continue
        own = found.own[result] if found.joint is None else up(found.own[result] + found.joint)
        if made.exact or (step.op in CHOOSER and not made.jumps):  # which are exact themselves
            own = np.zeros(made.count)
        partials = zip(found.partials[result], moved, strict=True)
        change = sum((times(p.magnitude, m) for p, m in partials if m.any()), own)
        change = up(np.where(np.isnan(change), np.inf, change))
        value = found.values[result].widened(own)
        for limit in _limits(net, step, result) if made.limited else ():
            wider = limit.widened(change)
            made.mark(step, value.apart(wider))
            value = value.meet(wider)
        made.values[name], made.moved[name] = value, change


def _limits(net: ErrorNetwork, step: Step, result: int) -> list[Boxes]:
    """Return what holds the exact, and what the computed, values of a result of valid samples."""
    if step.turns[result]:
        return []
    limits = []
    name, format_ = step.results[result], step.formats[result]
    if isinstance(format_, FixedPoint):
        largest = point(format_.largest_word * format_.ulp, 1)
        limits.append((-largest).join(largest))
    proven = None if name is None else net.proven.get(name)
    if proven is not None:
        limits.append(Boxes(np.array([proven.lo]), np.array([proven.hi])))
    return limits


def errors(net: ErrorNetwork, steps: Sequence[Step], output: str, made: Forward) -> Floats:
    """Return the bound of an output's error for each box; -inf where no sample counts, inf without bound."""
    source, empty = net.outputs[output], made.empty(steps)
    total = _leaving(net, output, made)
    if isinstance(source, Constant):
        return np.where(empty, -np.inf, total + source.error)
    adjoints = {source: point(1.0, made.count)}
    total = up(total + _backward(steps, made, adjoints))
    return np.where(empty, -np.inf, np.where(np.isnan(total), np.inf, total))


def least_square(
    net: ErrorNetwork, steps: Sequence[Step], boxes: Mapping[str, Boxes], thresholds: Mapping[str, float]
) -> tuple[Floats, Bools]:
    """Return the least square of the last step's margin over boxes, and the empty boxes.

    By the enclosure, and where no choice is made on the way also by the mean value theorem from the middle
    of the box, for which all of it counts, valid or not.
    """
    last = steps[-1]
    made = forward(net, steps, boxes, thresholds)
    least = made.squares[last.id].lo
    if any(step.op in CHOOSER for step in steps):
        return least, made.empty(steps)
    middles = {name: (box.lo + box.hi) / 2 for name, box in boxes.items()}
    centre = forward(net, steps, {n: Boxes(m, m) for n, m in middles.items()}, {}, exact=True, limited=False)
    whole = forward(net, steps, boxes, {}, limited=False)
    operands = [whole.operand(operand)[0] for operand in last.operands]
    adjoints: dict[str, Boxes] = {}
    total = np.zeros(whole.count)
    for operand, slope in zip(last.operands, margin_slopes(last, operands), strict=True):
        if isinstance(operand, Constant):
            total = total + times(slope.magnitude, operand.error)
        else:
            adjoints[operand] = adjoints[operand] + slope if operand in adjoints else slope
    radius = {
        name: np.maximum(box.hi - m, m - box.lo)
        for (name, box), m in zip(boxes.items(), middles.values(), strict=True)
    }
    total = up(total + _backward(steps[:-1], whole, adjoints, radius))
    centred = centre.squares[last.id].lo - total
    return np.where(np.isfinite(centred), np.maximum(least, centred), least), made.empty(steps)


def _backward(
    steps: Sequence[Step],
    made: Forward,
    adjoints: dict[str, Boxes],
    radius: Mapping[str, Floats] | None = None,
) -> Floats:
    """Return by how much all errors, and inputs that move by a radius, change what the adjoints are of."""
    total = np.zeros(made.count)

    def add(operand: str | Constant, change: Boxes) -> Floats:
        if isinstance(operand, Constant):
            return times(change.magnitude, operand.error)
        adjoints[operand] = adjoints[operand] + change if operand in adjoints else change
        return np.zeros(made.count)

    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        for step in reversed(steps):
            found = made.locals[step.id]
            wanted = [adjoints.pop(name, None) if name is not None else None for name in step.results]
            total = total + _own(found, wanted)
            for port, operand in enumerate(step.operands):
                change: Boxes | None = None
                for adjoint, partials in zip(wanted, found.partials, strict=True):
                    if adjoint is not None:
                        part = adjoint * partials[port]
                        change = part if change is None else change + part
                if change is not None:
                    total = total + add(operand, _turned(step, port, wanted, made, change))
        for name, adjoint in adjoints.items():
            moved = made.moved[name] if radius is None else made.moved[name] + radius[name]
            total = total + times(adjoint.magnitude, moved)
    return total


def _own(found: Local, wanted: Sequence[Boxes | None]) -> Floats:
    """Return what an operation's own error makes in the output."""
    sizes = [np.zeros(1) if adjoint is None else adjoint.magnitude for adjoint in wanted]
    total = sum((times(size, own) for size, own in zip(sizes, found.own, strict=True)), np.zeros(1))
    if found.joint is not None:
        total = total + times(up(np.hypot(sizes[0], sizes[1])), found.joint)
    return np.asarray(total)


def _turned(step: Step, port: int, wanted: Sequence[Boxes | None], made: Forward, change: Boxes) -> Boxes:
    """Use that circular rotation and vectoring turn a pair of adjoints: its length stays."""
    if step.params.get("m") != 1 or port == 2 or step.op not in ("rotate", "vector"):
        return change
    first, second = (np.zeros(1) if adjoint is None else adjoint.magnitude for adjoint in wanted)
    if step.op == "vector":
        low = np.maximum(made.locals[step.id].values[0].lo, 0.0)
        second = times(second, np.where(low > 0, 1 / np.where(low > 0, low, 1.0), np.inf))
    return change.within(up(np.hypot(first, second)))


def _leaving(net: ErrorNetwork, output: str, made: Forward) -> Floats:
    """Return the error of rounding to the output's format."""
    format_: NumberFormat = net.formats.outputs[output]
    source = net.outputs[output]
    box, _ = made.operand(source)
    inside = None if isinstance(source, Constant) else net.formats.values[source]
    if format_ == inside:
        return np.zeros(made.count)
    if (
        isinstance(format_, FixedPoint)
        and isinstance(inside, FixedPoint)
        and inside.fraction_bits <= format_.fraction_bits
    ):
        return np.zeros(made.count)
    return up(rounding(format_, box.magnitude))
