"""The modules of a plan's units: one for each kind and size, which several units may share."""

from __future__ import annotations

from dataclasses import replace

from cordicc.arith.circuits.builder import CircuitBuilder
from cordicc.arith.circuits.cell_delays import DELAYS
from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.plain_operations import ExactNumber, rounded
from cordicc.arith.circuits.units import Plain, unit_circuit
from cordicc.arith.circuits.uses import NoCircuitError, Use
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.backends.rtl.word_ports import WordFormats
from cordicc.plan.model import Operation, Plan
from cordicc.plan.netlist import Cell
from cordicc.targets.device import DEVICES


class UnitModules:
    """The circuits of a plan by the names of their modules.

    Attributes:
        circuits: by module, in the order in which they were asked for.
    """

    def __init__(self, plan: Plan, prefix: str) -> None:
        self._plan = plan
        self._words = WordFormats(plan)
        self._prefix = prefix
        device = DEVICES.get(plan.target.device or "")
        self._delays = DELAYS if device is None else device.delays
        self.circuits: dict[str, Circuit] = {}

    def of_unit(self, cell: Cell, interval: int) -> tuple[str, dict[int, int]]:
        """Return the module of a unit, and the number of the use by slot.

        Raises:
            NoCircuitError: an operation has no circuit; the message names those of the unit.
        """
        uses = tuple(dict.fromkeys(self._use(operation) for operation in cell.operations))
        modes = {
            operation.start % interval: uses.index(self._use(operation)) for operation in cell.operations
        }
        try:
            unit = cell.unit
            circuit = unit_circuit(
                "unit",
                self._plan.arithmetic,
                unit.kind,
                uses,
                unit.latency,
                self._delays,
                unit.initiation_interval,
            )
        except NoCircuitError as error:
            ids = ", ".join(f"{o.id} ({o.mode or o.op}, for {o.equation})" for o in cell.operations)
            raise NoCircuitError(f"{ids}: {error}") from None
        return self._named(cell.unit.kind, circuit), modes

    def of_rounding(self, held: FixedPoint, delivered: FixedPoint) -> str:
        """Return the module that rounds words between operations to those of an output."""
        b = CircuitBuilder("rounding")
        result = rounded(b, ExactNumber(b.word("a", held.width_bits), held.fraction_bits), delivered)
        b.output("first", b.as_word(result.word, delivered.width_bits))
        b.output("first_ok", result.valid)
        return self._named("rounding", b.circuit())

    def _named(self, kind: str, circuit: Circuit) -> str:
        """Return the module of a circuit: that of the same circuit if there is one."""
        alike = (circuit.cells, circuit.outputs, circuit.inputs, circuit.loops)
        for name, other in self.circuits.items():
            if (other.cells, other.outputs, other.inputs, other.loops) == alike:
                return name
        base = f"{self._prefix}_{kind}"
        name = f"{base}{sum(known.startswith(base) for known in self.circuits) + 1}"
        self.circuits[name] = replace(circuit, name=name)
        return name

    def _use(self, operation: Operation) -> Use | Plain:
        words, system = self._words, self._plan.arithmetic.system
        operands = tuple(words.of_operand(operand) for operand in operation.operands)
        results = tuple(None if name is None else words.held(name) for name in operation.results)
        constants = tuple(
            None if operand.constant is None else int(system.constant(operand.constant).words)
            for operand in operation.operands
        )
        if operation.kind in self._plan.arithmetic.caus:
            return Use(
                operation.op,
                -1 if operation.op == "lightcone" else operation.m or 0,
                operands,
                results,
                int(operation.params.get("sign", 1)),
                str(operation.params.get("branch", "-")),
                operation.angle,
                operation.slack,
                constants,
            )
        assert results[0] is not None
        return Plain(operation.op, tuple(operation.settings.items()), operands, results[0], constants)
