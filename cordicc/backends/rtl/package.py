"""The folder `rtl/` of a plan: its core, a stream around it, a bench with vectors, and what tools need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cordicc import __version__
from cordicc.arith.circuits.uses import NoCircuitError
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.backends.plain_templates import plain_templates
from cordicc.backends.rtl.bench_words import DEFAULT_COUNT, BenchWords, Run, bench_words, hex_lines
from cordicc.backends.rtl.core import Core, core_of
from cordicc.backends.rtl.file_headers import file_header
from cordicc.backends.rtl.module_text import module_text
from cordicc.backends.rtl.names import comment
from cordicc.backends.rtl.port_table import port_table
from cordicc.backends.rtl.reset_style import USUAL_RESET, ResetStyle
from cordicc.backends.rtl.stream_fields import stream_texts
from cordicc.backends.rtl.stream_proof import is_proven, proof_texts
from cordicc.backends.rtl.word_ports import Ports
from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.plan.model import Plan


def files(
    plan: Plan, run: Run, count: int = DEFAULT_COUNT, reset: ResetStyle = USUAL_RESET
) -> dict[str, str]:
    """Return the texts of the folder by name, `rtl/` before each.

    Args:
        plan: what is written.
        run: runs the plan, for the vectors of the bench.
        count: samples of the bench that are drawn at random.
        reset: its style.

    Raises:
        Unattainable: the plan cannot be written in Verilog (E421).
    """
    package = _Package(plan, core_in_verilog(plan, reset))
    words = bench_words(Ports.of(plan), plan.problem.workspace, count, run)
    return {f"rtl/{name}": text for name, text in package.files(words).items()}


def core_in_verilog(plan: Plan, reset: ResetStyle) -> Core:
    """Return the core of a plan; raises Unattainable (E421) where it has none."""
    if not isinstance(plan.arithmetic.system, FixedSystem):
        message = (
            f"the plan cannot be written in Verilog: the words of target '{plan.target.name}' are in "
            "floating point, of which there are no circuits"
        )
        raise Unattainable([Diagnostic("E421", message, hint="a fixed-point target: --target fixed24")])
    try:
        about = "The plan as a pipeline: its units, FIFOs and valid bits."
        return core_of(plan, file_header(plan, about, reset), reset)
    except NoCircuitError as error:
        message = f"the plan cannot be written in Verilog: {error}"
        raise Unattainable([Diagnostic("E421", message, hint="'wrap: false', or a smaller range")]) from None


@dataclass(frozen=True)
class _Package:
    plan: Plan
    core: Core

    def files(self, words: BenchWords) -> dict[str, str]:
        """Return the texts by name."""
        core, name = self.core, self.core.name
        ins = list(zip(core.inputs, words.given, strict=True))
        outs = list(zip(core.outputs, words.wanted, strict=True))
        made = {f"{name}_core.v": core.text}
        for module, circuit in core.modules.items():
            made[f"{module}.v"] = module_text(circuit, self._unit_header(module))
        made[f"{name}_axis.v"] = self._verilog(
            "axis.v.j2", "AXI4-Stream around the core, with back-pressure."
        )
        context = {"samples": words.count}
        made[f"{name}_tb.v"] = self._verilog("tb.v.j2", "A bench that checks itself: PASS, or FAIL.", context)
        made[f"vectors/{name}_in.hex"] = hex_lines(ins)
        made[f"vectors/{name}_out.hex"] = hex_lines(outs, words.ok)
        others = [
            (f"{name}.core", "fusesoc.core.j2"),
            (f"{name}.sdc", "constraints.sdc.j2"),
            ("Makefile", "Makefile.j2"),
        ]
        if is_proven(core):
            made[f"formal/{name}_axis_properties.v"] = self._verilog(
                "stream_properties.v.j2", "What the stream keeps, whatever waits."
            )
            made[f"formal/{name}_axis_proof.v"] = self._verilog(
                "stream_proof.v.j2", "What is proven: the stream."
            )
            others.append((f"formal/{name}_axis.sby", "stream.sby.j2"))
            others.append(("formal/prepare.ys", "prepare.ys.j2"))
        for file, template in others:
            made[file] = self._text(template, "# ", _ABOUT[template])
        made["README.md"] = port_table(self.plan, core)
        return made

    def _unit_header(self, module: str) -> list[str]:
        units = [unit for unit, own in self.core.units.items() if own == module]
        about = (
            "Unit" + "s" * (len(units) > 1) + f" {', '.join(units)}."
            if units
            else "Rounds to the words of an output."
        )
        return file_header(self.plan, about, self.core.reset)

    def _verilog(self, template: str, about: str, more: Mapping[str, Any] | None = None) -> str:
        return self._text(template, "// ", about, more)

    def _text(self, template: str, mark: str, about: str, more: Mapping[str, Any] | None = None) -> str:
        header = "\n".join(f"{mark}{line}" for line in file_header(self.plan, about, self.core.reset))
        context = {**self._context, **(more or {}), "header": header}
        return plain_templates("cordicc.backends.rtl").get_template(template).render(context)

    @cached_property
    def _context(self) -> Mapping[str, Any]:
        """What the templates take."""
        core, plan = self.core, self.plan
        depth = -(-core.latency // core.interval) + 2
        stream = stream_texts(core.inputs, core.outputs)
        out_bits = 1 + sum(port.width for port in core.outputs)
        return {
            "name": core.name,
            "version": __version__,
            "description": comment(" ".join(plan.description.split()) or plan.name).replace('"', "'"),
            "outputs": core.outputs,
            "interval": core.interval,
            "reset": core.reset,
            "formal": is_proven(core),
            "latency": core.latency,
            "rtl": [f"{core.name}_axis.v", f"{core.name}_core.v", *(f"{each}.v" for each in core.modules)],
            "depth": depth,
            "reset_fails": " || ".join(f"({bit} !== 1'b0)" for bit in _low_in_reset(core)),
            "count_bits": depth.bit_length(),
            "place_bits": (depth - 1).bit_length(),
            "core_word": ", ".join(f"core_{port.port}" for port in reversed(core.outputs)),
            "clock": f"{plan.clock_hz / 1e6:g} MHz",
            "period": f"{1e9 / plan.clock_hz:.3f}",
            **stream,
            **(proof_texts(core, depth, out_bits) if is_proven(core) else {}),
        }


def _low_in_reset(core: Core) -> list[str]:
    """Return what the bench sees low while the reset is active; a core without registers has no such bit."""
    of_core = (["in_ready"] if core.interval > 1 else []) + (["out_valid"] if core.latency else [])
    return [*of_core, "m_tvalid", "s_tready"]


_ABOUT = {
    "fusesoc.core.j2": "For FuseSoC (CAPI2).",
    "constraints.sdc.j2": "Constraints to begin with.",
    "Makefile.j2": "make sim: Icarus Verilog; make verilate, make lint: Verilator; make formal: yosys.",
    "stream.sby.j2": "For SymbiYosys.",
    "prepare.ys.j2": "For yosys: the stream and what it keeps, ready for a proof.",
}
