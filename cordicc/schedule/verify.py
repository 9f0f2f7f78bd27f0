"""Independent verification of a finished plan.

Works from the plan alone, with nothing of the scheduler, and says what is wrong.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cordicc.plan import Fifo, Operation, Plan
from cordicc.targets.model import CAU_KINDS


@dataclass(frozen=True, slots=True)
class _Use:
    """A sink (`o3.y`, `out.theta`), the value it takes and the cycle in which it does."""

    sink: str
    value: str
    cycle: int


def verify(plan: Plan) -> None:
    """Raise AssertionError unless the plan can run as it stands and counts itself correctly.

    Covered: unique ids, dependences, units (latency, one operation a slot), FIFO chains and their
    depths, nothing dangling, latency, CAU cycles, FIFO words.
    """
    _require(plan.initiation_interval >= 1, f"initiation interval {plan.initiation_interval}")
    _unique("operation", (operation.id for operation in plan.operations))
    _unique("unit", (unit.id for unit in plan.units))
    _unique("FIFO", (fifo.id for fifo in plan.fifos))
    named = (name for operation in plan.operations for name in operation.results if name)
    _unique("value", [*_inputs(plan), *named])
    for operation in plan.operations:
        _check_operation(plan, operation)
    _check_slots(plan)
    uses = _uses(plan)
    _check_uses(plan, uses)
    _check_fifos(plan, uses)
    _check_sums(plan)


def _check_operation(plan: Plan, operation: Operation) -> None:
    unit = next((unit for unit in plan.units if unit.id == operation.unit), None)
    _require(unit is not None, f"{operation.id}: unknown unit '{operation.unit}'")
    assert unit is not None
    _require(unit.kind == operation.kind, f"{operation.id}: kind {operation.kind} on a {unit.kind} unit")
    _require(operation.start >= 0, f"{operation.id}: starts in cycle {operation.start}")
    _require(
        operation.finish == operation.start + unit.latency,
        f"{operation.id}: from {operation.start} to {operation.finish} on a unit of {unit.latency} cycles",
    )
    _require(operation.finish <= plan.latency_cycles, f"{operation.id}: finishes after the outputs left")
    _require(len(operation.ports) == len(operation.operands), f"{operation.id}: ports and operands differ")
    _unique(f"port of {operation.id}", operation.ports)
    named = [name for name in operation.results if name is not None]
    _require(bool(named), f"{operation.id}: nobody takes a result")
    for name in named:
        _require(name.startswith(f"{operation.id}."), f"{operation.id}: result named '{name}'")


def _check_slots(plan: Plan) -> None:
    taken: dict[tuple[str, int], str] = {}
    for operation in plan.operations:
        slot = operation.unit, operation.start % plan.initiation_interval
        _require(slot not in taken, f"{operation.id} and {taken.get(slot)} share slot {slot[1]} of {slot[0]}")
        taken[slot] = operation.id


def _uses(plan: Plan) -> dict[str, _Use]:
    """Return the ports and outputs that take a value, by sink."""
    found: dict[str, _Use] = {}
    for operation in plan.operations:
        for port, operand in zip(operation.ports, operation.operands, strict=True):
            sink = f"{operation.id}.{port}"
            _require((operand.value is None) != (operand.constant is None), f"{sink}: value or constant?")
            if operand.value is not None:
                found[sink] = _Use(sink, operand.value, operation.start)
    for name, operand in plan.outputs.items():
        sink = f"out.{name}"
        _require((operand.value is None) != (operand.constant is None), f"{sink}: value or constant?")
        if operand.value is not None:
            found[sink] = _Use(sink, operand.value, plan.latency_cycles)
    return found


def _check_uses(plan: Plan, uses: dict[str, _Use]) -> None:
    ready = _ready(plan)
    for use in uses.values():
        _require(use.value in ready, f"{use.sink}: takes unknown value '{use.value}'")
        _require(
            ready[use.value] <= use.cycle,
            f"{use.sink}: takes '{use.value}' in cycle {use.cycle}, ready in {ready[use.value]}",
        )
    taken = {use.value for use in uses.values()}
    for name in ready:
        _require(name in taken or name in _inputs(plan), f"nobody takes '{name}'")
    _check_acyclic(plan)


def _check_acyclic(plan: Plan) -> None:
    """Operations of zero latency could depend on one another within a cycle."""
    maker = {name: operation.id for operation in plan.operations for name in operation.results if name}
    waiting = {
        operation.id: {maker[o.value] for o in operation.operands if o.value in maker}
        for operation in plan.operations
    }
    while waiting:
        free = [id for id, before in waiting.items() if not before & waiting.keys()]
        _require(bool(free), f"operations depend on one another: {', '.join(waiting)}")
        for id in free:
            del waiting[id]


def _check_fifos(plan: Plan, uses: dict[str, _Use]) -> None:
    """Follow every value from its source along the segments."""
    fifos = {fifo.id: fifo for fifo in plan.fifos}
    _unique("FIFO sink", (sink for fifo in plan.fifos for sink in fifo.sinks))
    source = _sources(plan)
    for fifo in plan.fifos:
        _require(fifo.value in source, f"{fifo.id}: delays unknown value '{fifo.value}'")
        _require(fifo.width > 0, f"{fifo.id}: width {fifo.width}")
        for sink in fifo.sinks:
            taken = fifos[sink].value if sink in fifos else uses[sink].value if sink in uses else None
            _require(taken is not None, f"{fifo.id}: feeds unknown sink '{sink}'")
            _require(taken == fifo.value, f"{fifo.id}: holds '{fifo.value}', but '{sink}' takes '{taken}'")
    onward = {sink: fifo.id for fifo in plan.fifos for sink in fifo.sinks if sink in fifos}
    for fifo in plan.fifos:
        expected = onward.get(fifo.id, source[fifo.value])
        _require(fifo.source == expected, f"{fifo.id}: fed by '{fifo.source}', expected '{expected}'")
    delayed: set[str] = set()
    seen: set[str] = set()
    for head in plan.fifos:
        if head.id not in onward:
            for fifo in _check_chain(plan, head, fifos, uses):
                seen.add(fifo.id)
                delayed.update(fifo.sinks)
    _require(len(seen) == len(fifos), f"FIFOs in a ring: {', '.join(sorted(fifos.keys() - seen))}")
    ready = _ready(plan)
    for use in uses.values():
        wait = use.cycle - ready[use.value]
        _require(
            use.sink in delayed or wait == 0, f"{use.sink}: takes '{use.value}' directly, {wait} cycles late"
        )


def _check_chain(plan: Plan, head: Fifo, fifos: dict[str, Fifo], uses: dict[str, _Use]) -> list[Fifo]:
    """Check the taps and depths of a chain; return its segments."""
    arrival = _ready(plan)[head.value]
    chain = [head]
    while True:
        fifo = chain[-1]
        following = [fifos[sink] for sink in fifo.sinks if sink in fifos]
        taps = {uses[sink].cycle for sink in fifo.sinks if sink in uses}
        _require(len(following) <= 1, f"{fifo.id}: goes on into several FIFOs")
        _require(len(taps) == 1, f"{fifo.id}: its sinks read in cycles {sorted(taps)}, expected one")
        wait = taps.pop() - arrival
        depth = -(-wait // plan.initiation_interval)
        _require(depth >= 1 and fifo.depth == depth, f"{fifo.id}: depth {fifo.depth} for {wait} cycles")
        if not following:
            return chain
        arrival += wait
        chain.append(following[0])


def _check_sums(plan: Plan) -> None:
    words = sum(fifo.depth for fifo in plan.fifos)
    achieved = {"latency": plan.latency_cycles, "fifo_words": words}
    for name, figure in achieved.items():
        bound = plan.bounds.get(name)
        if bound is not None:
            _require(bound <= figure, f"{name}: {figure} is below its bound {bound}")
        if plan.optimal.get(name):
            _require(bound == figure, f"{name}: {figure} is called optimal with bound {bound}")
    cau_cycles = _cau_cycles(plan)
    _require(plan.cau_cycles == cau_cycles, f"CAU cycles: {plan.cau_cycles}, expected {cau_cycles}")


def _cau_cycles(plan: Plan) -> int:
    """Return the largest sum of CAU stages on any path."""
    longest = dict.fromkeys(_inputs(plan), 0)
    todo = list(plan.operations)
    best = 0
    while todo:
        rest: list[Operation] = []
        for operation in todo:
            taken = [operand.value for operand in operation.operands if operand.value is not None]
            if any(name not in longest for name in taken):
                rest.append(operation)
                continue
            own = operation.finish - operation.start if operation.kind in CAU_KINDS else 0
            total = own + max((longest[name] for name in taken), default=0)
            best = max(best, total)
            longest.update((name, total) for name in operation.results if name)
        todo = rest
    return best


def _inputs(plan: Plan) -> list[str]:
    return [item["name"] for item in plan.problem["inputs"]]


def _sources(plan: Plan) -> dict[str, str]:
    """Return the producing operation of every value, an input being its own source."""
    found = {name: name for name in _inputs(plan)}
    found.update((name, o.id) for o in plan.operations for name in o.results if name)
    return found


def _ready(plan: Plan) -> dict[str, int]:
    """Return the cycle from which each value is usable."""
    found = dict.fromkeys(_inputs(plan), 0)
    found.update((name, o.finish) for o in plan.operations for name in o.results if name)
    return found


def _unique(what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        _require(name not in seen, f"{what} '{name}' occurs twice")
        seen.add(name)


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise AssertionError(message)
