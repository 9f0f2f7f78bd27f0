"""Which port takes its value from where: the nets of a plan, FIFOs taken into account."""

from __future__ import annotations

from dataclasses import replace

from cordicc.backends.pictures.layout import Net, Pin
from cordicc.plan.model import Operand, Operation, Plan
from cordicc.plan.netlist import FifoEnd, Netlist


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
    netlist = Netlist.of(plan if with_fifos else replace(plan, fifos=()))
    pins = {name: Pin(f"in.{name}", 0) for name in input_names(plan)}
    pins |= {
        name: Pin(f"op.{result.operation.id}", result.position) for name, result in netlist.results.items()
    }
    sinks = {fifo: Pin(f"fifo.{fifo}", 0) for fifo in netlist.fifos}
    sinks |= {f"out.{name}": Pin(f"out.{name}", 0) for name in netlist.outputs}
    for id, ports in netlist.operands.items():
        live = [connection.sink for connection in ports if connection.value is not None]
        sinks |= {sink: Pin(f"op.{id}", place) for place, sink in enumerate(live)}
    found: dict[Pin, tuple[str, list[Pin]]] = {}
    for connection in netlist.connections():
        value, driver = connection.value, connection.driver
        source = Pin(f"fifo.{driver.fifo}", 0) if isinstance(driver, FifoEnd) else pins.get(value or "")
        if value is not None and source is not None:
            found.setdefault(source, (value, []))[1].append(sinks[connection.sink])
    return [Net(value, source, tuple(ends)) for source, (value, ends) in found.items()]
