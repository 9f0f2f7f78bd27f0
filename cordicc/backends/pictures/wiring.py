"""Which port takes its value from where: the nets of a plan, FIFOs taken into account."""

from __future__ import annotations

from dataclasses import replace

from cordicc.backends.pictures.layout import Net, Pin
from cordicc.plan.model import Operand, Operation, Plan
from cordicc.plan.netlist import FifoEnd, Netlist


def live_inputs(operation: Operation) -> list[tuple[str, Operand]]:
    """Return the ports that take a value, not a constant."""
    pairs = zip(operation.ports, operation.operands, strict=False)
    return [(port, item) for port, item in pairs if item.value is not None]


def nets(plan: Plan, *, with_fifos: bool = True) -> list[Net]:
    """Return the nets between the boxes `in.NAME`, `op.ID`, `fifo.ID` and `out.NAME`.

    Input pins count the ports that take a value; output pins count all results.
    """
    netlist = Netlist.of(plan if with_fifos else replace(plan, fifos=()))
    pins = {name: Pin(f"in.{name}", 0) for name in plan.problem.input_names}
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
        if value is not None:
            source = Pin(f"fifo.{driver.fifo}", 0) if isinstance(driver, FifoEnd) else pins[value]
            found.setdefault(source, (value, []))[1].append(sinks[connection.sink])
    return [Net(value, source, tuple(ends)) for source, (value, ends) in found.items()]
