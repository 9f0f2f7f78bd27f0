"""Which port takes its value from where: the nets of a plan, FIFOs taken into account."""

from __future__ import annotations

from cordicc.backends.pictures.layout import Net, Pin
from cordicc.plan.model import Fifo, Operand, Operation, Plan


def input_names(plan: Plan) -> tuple[str, ...]:
    """Return the inputs in the order of the problem, then any others that the plan takes."""
    declared = plan.problem.input_names
    made = {name for operation in plan.operations for name in operation.results if name}
    taken = [item.value for operation in plan.operations for item in operation.operands]
    taken += [item.value for item in plan.outputs.values()]
    others = [name for name in taken if name is not None and name not in made]
    return tuple(dict.fromkeys([*declared, *others]))


def live_inputs(operation: Operation) -> list[tuple[str, Operand]]:
    """Return the ports that take a value, not a constant."""
    pairs = zip(operation.ports, operation.operands, strict=False)
    return [(port, item) for port, item in pairs if item.value is not None]


def nets(plan: Plan, *, with_fifos: bool = True) -> list[Net]:
    """Return the nets between the boxes `in.NAME`, `op.ID`, `fifo.ID` and `out.NAME`.

    Input pins count the ports that take a value; output pins count all results.
    """
    drivers = {name: Pin(f"in.{name}", 0) for name in input_names(plan)}
    for operation in plan.operations:
        drivers |= {
            name: Pin(f"op.{operation.id}", port) for port, name in enumerate(operation.results) if name
        }
    fifos = plan.fifos if with_fifos else ()
    by_id = {fifo.id: fifo for fifo in fifos}
    taps = {sink: fifo for fifo in fifos for sink in fifo.sinks if sink not in by_id}
    sinks: dict[Pin, list[Pin]] = {}

    def connect(port: str, value: str, sink: Pin) -> None:
        source = Pin(f"fifo.{taps[port].id}", 0) if port in taps else drivers.get(value)
        if source is not None:
            sinks.setdefault(source, []).append(sink)

    for fifo in fifos:
        before = _before(fifo, by_id)
        start = Pin(f"fifo.{before.id}", 0) if before else drivers.get(fifo.value)
        if start is not None:
            sinks.setdefault(start, []).append(Pin(f"fifo.{fifo.id}", 0))
    for operation in plan.operations:
        for index, (port, item) in enumerate(live_inputs(operation)):
            connect(f"{operation.id}.{port}", str(item.value), Pin(f"op.{operation.id}", index))
    for name, item in plan.outputs.items():
        if item.value is not None:
            connect(f"out.{name}", item.value, Pin(f"out.{name}", 0))
    labels = {pin: name for name, pin in drivers.items()} | {Pin(f"fifo.{f.id}", 0): f.value for f in fifos}
    return [Net(labels[source], source, tuple(ends)) for source, ends in sinks.items()]


def _before(fifo: Fifo, by_id: dict[str, Fifo]) -> Fifo | None:
    """Return the segment that feeds `fifo`, if it is not the first of its value."""
    before = by_id.get(fifo.source)
    return before if before is not None and before.value == fifo.value and before is not fifo else None
