"""What the drivers of a plan's netlist are called in Verilog, and how wide they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.units import RESULTS
from cordicc.backends.rtl.module_text import literal
from cordicc.backends.rtl.reset_style import RESETS
from cordicc.backends.rtl.word_ports import Ports, WordFormats
from cordicc.plan.model import Plan
from cordicc.plan.netlist import ConstantWord, Driver, FifoEnd, InputWord, Netlist, UnitResult

_OWN_PORTS = ("clk", *RESETS, "ce", "in_valid", "in_ready", "out_valid", "out_ok")


class Wires:
    """The wires of a core: none of them has the name of a port or of another one.

    Args:
        plan: whose core it is.
        netlist: that of the plan.
        ports: of the core.
        units: the circuit of each unit.
    """

    def __init__(self, plan: Plan, netlist: Netlist, ports: Ports, units: Mapping[str, Circuit]) -> None:
        self._plan = plan
        self._netlist = netlist
        self._units = units
        self._words = WordFormats(plan)
        self._fifo = {fifo.id: fifo for fifo in plan.fifos}
        self._input = {port.name: port.port for port in ports.inputs}
        self._position = {each.driver: each.position for each in netlist.results.values()}
        self._taken = {*_OWN_PORTS, *(port.port for port in (*ports.inputs, *ports.outputs))}
        self._names: dict[tuple[str, str], str] = {}

    def name(self, owner: str, wanted: str) -> str:
        """Return the name of a signal: what is wanted, with underscores behind it if that is taken.

        Args:
            owner: what kind of thing the signal belongs to; two of them may want one name.
            wanted: an identifier.
        """
        key = (owner, wanted)
        if key not in self._names:
            while wanted in self._taken:
                wanted += "_"
            self._taken.add(wanted)
            self._names[key] = wanted
        return self._names[key]

    def word(self, driver: Driver) -> str:
        """Return the wire of what a driver carries; a constant has none."""
        match driver:
            case InputWord(name):
                return self._input[name]
            case FifoEnd(fifo) if not self._fifo[fifo].depth:
                return self.word(self._netlist.fifos[fifo].driver)
            case FifoEnd(fifo):
                return self.name("fifo", f"{fifo}_end")
            case UnitResult(unit, _):
                return self.name("unit", f"{unit}_{RESULTS[self._position[driver]]}")
        raise AssertionError(driver)

    def ok(self, driver: Driver) -> str:
        """Return the wire that tells whether that stands for a number."""
        match driver:
            case InputWord(name):
                return self.name("input", f"{self._input[name]}_ok")
            case FifoEnd(fifo) if not self._fifo[fifo].depth:
                return self.ok(self._netlist.fifos[fifo].driver)
            case FifoEnd(fifo):
                return self.name("fifo", f"{fifo}_end_ok")
            case UnitResult(unit, _):
                return self.name("unit", f"{unit}_{RESULTS[self._position[driver]]}_ok")
        raise AssertionError(driver)

    def width(self, driver: Driver) -> int:
        """Return the bits of what a driver carries."""
        match driver:
            case InputWord(name):
                return self._words.held(name).width_bits
            case FifoEnd(fifo) if not self._fifo[fifo].depth:
                return self.width(self._netlist.fifos[fifo].driver)
            case FifoEnd(fifo):
                return self._words.held(self._fifo[fifo].value).width_bits
            case UnitResult(unit, _):
                return _width(self._units[unit], RESULTS[self._position[driver]])
        raise AssertionError(driver)

    def sized(self, driver: Driver, width: int) -> str:
        """Return what a driver carries, in a width."""
        if isinstance(driver, ConstantWord):
            return literal(int(self._plan.arithmetic.system.constant(driver.text).words), width)
        own, text = self.width(driver), self.word(driver)
        if own == width:
            return text
        if own > width:
            return f"{text}[{width - 1}:0]"
        return f"{{{{{width - own}{{{text}[{own - 1}]}}}}, {text}}}"

    def declared(self) -> Iterator[str]:
        """Yield the declarations of the results of units and of the ends of FIFOs."""
        for unit, circuit in self._units.items():
            for port in circuit.outputs:
                yield _wire(self.name("unit", f"{unit}_{port.name}"), circuit.cells[port.cell].width)
        for fifo in self._plan.fifos:
            if fifo.depth:
                end = FifoEnd(fifo.id)
                yield _wire(self.word(end), self.width(end))
                yield _wire(self.ok(end), 1)

    def all_ok(self, drivers: Iterable[Driver]) -> str:
        """Return the condition that all of what drivers carry stands for numbers; constants do."""
        bits = dict.fromkeys(self.ok(d) for d in drivers if not isinstance(d, ConstantWord))
        return " && ".join(bits) or literal(1, 1)


def _wire(name: str, width: int) -> str:
    """Return the declaration of a word, or of a bit that tells of one."""
    return f"wire signed [{width - 1}:0] {name};" if width > 1 else f"wire {name};"


def _width(circuit: Circuit, port: str) -> int:
    """Return the bits of an output of a circuit."""
    return next(circuit.cells[each.cell].width for each in circuit.outputs if each.name == port)
