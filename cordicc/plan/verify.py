"""Independent verification of a finished plan.

Works from the plan alone, with nothing of the scheduler, and says what is wrong.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cordicc.plan.model import Fifo, Operation, Plan, Unit
from cordicc.targets.target import CAU_KINDS


@dataclass(frozen=True, slots=True)
class _Use:
    """A sink (`o3.y`, `out.theta`), the value it takes and the cycle in which it does."""

    sink: str
    value: str
    cycle: int


def verify(plan: Plan) -> None:
    """Raise AssertionError unless the plan can run as it stands and counts itself correctly.

    Covered: unique ids, dependences, units (latency, one operation at a time), FIFO chains and their
    depths, nothing dangling, multiplexers and control words, latency, CAU cycles, FIFO words.  Takes time
    linear in the size of the plan.
    """
    _require(plan.initiation_interval >= 1, f"initiation interval {plan.initiation_interval}")
    _unique("operation", (operation.id for operation in plan.operations))
    _unique("unit", (unit.id for unit in plan.units))
    _unique("FIFO", (fifo.id for fifo in plan.fifos))
    named = (name for operation in plan.operations for name in operation.results if name)
    _unique("value", [*_inputs(plan), *named])
    units = {unit.id: unit for unit in plan.units}
    for operation in plan.operations:
        _check_operation(plan, units.get(operation.unit), operation)
    _check_slots(plan)
    uses = _uses(plan)
    ready = _ready(plan)
    _check_uses(plan, uses, ready)
    _check_fifos(plan, uses, ready)
    _check_control(plan)
    _check_sums(plan)


def _check_operation(plan: Plan, unit: Unit | None, operation: Operation) -> None:
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
    interval = {unit.id: unit.initiation_interval for unit in plan.units}
    for unit, cycles in interval.items():
        _require(1 <= cycles <= plan.initiation_interval, f"{unit}: takes an operation every {cycles} cycles")
    for operation in plan.operations:
        for later in range(interval[operation.unit]):
            slot = operation.unit, (operation.start + later) % plan.initiation_interval
            _require(
                slot not in taken, f"{operation.id} and {taken.get(slot)} share slot {slot[1]} of {slot[0]}"
            )
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


def _check_uses(plan: Plan, uses: dict[str, _Use], ready: dict[str, int]) -> None:
    for use in uses.values():
        _require(use.value in ready, f"{use.sink}: takes unknown value '{use.value}'")
        _require(
            ready[use.value] <= use.cycle,
            f"{use.sink}: takes '{use.value}' in cycle {use.cycle}, ready in {ready[use.value]}",
        )
    accounted_for = {use.value for use in uses.values()} | set(_inputs(plan))
    for name in ready:
        _require(name in accounted_for, f"nobody takes '{name}'")
    order = _dependence_order(plan)
    stuck = [operation.id for operation in plan.operations if operation.id not in order]
    # Operations of zero latency could depend on one another within a cycle.
    _require(not stuck, f"operations depend on one another: {', '.join(stuck)}")


def _dependence_order(plan: Plan) -> dict[str, Operation]:
    """Return the operations by id, each after those it takes values of; those in a loop are missing."""
    maker = {name: operation.id for operation in plan.operations for name in operation.results if name}
    takers: dict[str, list[Operation]] = {}
    missing: dict[str, int] = {}
    for operation in plan.operations:
        before = {maker[o.value] for o in operation.operands if o.value in maker}
        missing[operation.id] = len(before)
        for id in before:
            takers.setdefault(id, []).append(operation)
    free = [operation for operation in plan.operations if not missing[operation.id]]
    for operation in free:
        for taker in takers.get(operation.id, ()):
            missing[taker.id] -= 1
            if not missing[taker.id]:
                free.append(taker)
    return {operation.id: operation for operation in free}


def _check_fifos(plan: Plan, uses: dict[str, _Use], ready: dict[str, int]) -> None:
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
            for fifo in _check_chain(head, fifos, uses, ready[head.value], plan.initiation_interval):
                seen.add(fifo.id)
                delayed.update(fifo.sinks)
    _require(len(seen) == len(fifos), f"FIFOs in a ring: {', '.join(sorted(fifos.keys() - seen))}")
    for use in uses.values():
        wait = use.cycle - ready[use.value]
        _require(
            use.sink in delayed or wait == 0, f"{use.sink}: takes '{use.value}' directly, {wait} cycles late"
        )


def _check_chain(
    head: Fifo, fifos: dict[str, Fifo], uses: dict[str, _Use], arrival: int, interval: int
) -> list[Fifo]:
    """Check the taps and depths of a chain that a value enters on its arrival; return its segments."""
    chain = [head]
    while True:
        fifo = chain[-1]
        following = [fifos[sink] for sink in fifo.sinks if sink in fifos]
        taps = {uses[sink].cycle for sink in fifo.sinks if sink in uses}
        _require(len(following) <= 1, f"{fifo.id}: goes on into several FIFOs")
        _require(len(taps) == 1, f"{fifo.id}: its sinks read in cycles {sorted(taps)}, expected one")
        wait = taps.pop() - arrival
        depth = -(-wait // interval)
        _require(depth >= 1 and fifo.depth == depth, f"{fifo.id}: depth {fifo.depth} for {wait} cycles")
        if not following:
            return chain
        arrival += wait
        chain.append(following[0])


def _check_control(plan: Plan) -> None:
    """Check the multiplexers and control words of shared units."""
    feeder = {sink: f"fifo {fifo.id}" for fifo in plan.fifos for sink in fifo.sinks}
    source = {name: f"input {name}" for name in _inputs(plan)}
    on: dict[str, list[Operation]] = {}
    for operation in plan.operations:
        on.setdefault(operation.unit, []).append(operation)
        for name in operation.results:
            if name:
                source[name] = f"unit {operation.unit}.{name.rpartition('.')[2]}"
    for unit in plan.units:
        if not unit.control and not unit.inputs:
            _require(len(on.get(unit.id, ())) <= 1, f"{unit.id}: shared, but without control words")
            continue
        words = {word.operation: word for word in unit.control}
        held = [operation.id for operation in on.get(unit.id, ())]
        _require(sorted(words) == sorted(held), f"{unit.id}: control words of other operations")
        _require(len(words) == len(unit.control), f"{unit.id}: an operation has several control words")
        for operation in on.get(unit.id, ()):
            word = words[operation.id]
            _require(word.slot == operation.start % plan.initiation_interval, f"{operation.id}: wrong slot")
            _require(len(word.select) == len(operation.ports), f"{operation.id}: ports without a selection")
            for port, operand, inputs, chosen in zip(
                operation.ports, operation.operands, unit.inputs, word.select, strict=False
            ):
                sink = f"{operation.id}.{port}"
                wanted = f"constant {operand.constant}"
                if operand.value is not None:
                    wanted = feeder.get(sink, source[operand.value])
                given = inputs[chosen] if 0 <= chosen < len(inputs) else "nothing"
                _require(given == wanted, f"{sink}: selects {given}, expected {wanted}")
            _require(len(unit.inputs) >= len(operation.ports), f"{unit.id}: ports without inputs")


def _check_sums(plan: Plan) -> None:
    words = sum(fifo.depth for fifo in plan.fifos)
    caus = sum(unit.kind in CAU_KINDS for unit in plan.units)
    achieved = {"processors": caus, "latency": plan.latency_cycles, "fifo_words": words}
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
    best = 0
    for operation in _dependence_order(plan).values():
        own = operation.finish - operation.start if operation.kind in CAU_KINDS else 0
        total = own + max((longest[o.value] for o in operation.operands if o.value is not None), default=0)
        best = max(best, total)
        longest.update((name, total) for name in operation.results if name)
    return best


def _inputs(plan: Plan) -> list[str]:
    return list(plan.problem.input_names)


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
