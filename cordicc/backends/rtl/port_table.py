"""README.md of a plan's hardware: ports, formats, ranges, handshake."""

from __future__ import annotations

import math

from cordicc.backends.plain_templates import plain_templates
from cordicc.backends.rtl.core import Core
from cordicc.backends.rtl.file_headers import LICENCE, command_line
from cordicc.backends.rtl.stream_fields import byte_fields
from cordicc.backends.rtl.stream_proof import is_proven
from cordicc.backends.rtl.word_ports import PortWord
from cordicc.plan.model import Plan


def port_table(plan: Plan, core: Core) -> str:
    """Return the text of the page."""
    context = {
        "title": plan.name,
        "description": " ".join(plan.description.split()),
        "name": core.name,
        "command": command_line(plan, core.reset),
        "licence": LICENCE,
        "latency": core.latency,
        "interval": core.interval,
        "reset": core.reset,
        "formal": is_proven(core),
        "depth": -(-core.latency // core.interval) + 2,
        "rounding": plan.arithmetic.spec["format"].get("rounding", "half-up"),
        "clock": f"{plan.clock_hz / 1e6:g} MHz",
        "resources": _resources(plan),
        "equations": [each.text for each in plan.problem.equations],
        "inputs": [_input_row(port, at) for port, at in byte_fields(core.inputs)],
        "outputs": [_output_row(plan, port, at) for port, at in byte_fields(core.outputs)],
    }
    return plain_templates("cordicc.backends.rtl").get_template("README.md.j2").render(context)


def _resources(plan: Plan) -> str:
    """Say what the core takes of its device, as it is estimated; nothing without a device."""
    area = plan.estimate
    if area is None or plan.target.device is None:
        return ""
    logic = f"{area.lut:,} LUT, {area.ff:,} FF, {area.dsp:,} DSP"
    return f"{logic} and {area.ram_bits:,} bits of RAM of {plan.target.device}"


def _format(port: PortWord) -> str:
    """Return the binary point of a port: bits before it, the sign among them, and behind it."""
    fraction = port.format.fraction_bits
    return f"Q{port.width - fraction}.{fraction}"


def _common(port: PortWord, at: int) -> list[str]:
    return [
        f"`{port.port}`",
        f"{port.width}",
        _format(port),
        f"2^{-port.format.fraction_bits} {port.unit}".rstrip(),
        f"{at + 8 * port.field_bytes - 1}:{at}",
    ]


def _input_row(port: PortWord, at: int) -> list[str]:
    return [
        *_common(port, at),
        "any: nothing takes it" if port.lo is None else f"{port.lo!r} to {port.hi!r} {port.unit}".rstrip(),
        f"{port.least} to {port.most}",
    ]


def _output_row(plan: Plan, port: PortWord, at: int) -> list[str]:
    output = next(each for each in plan.problem.outputs if each.name == port.name)
    end = port.format.largest_word * 2.0**-port.format.fraction_bits
    wrapped = output.is_angle and output.wrap and end > math.pi
    reach = "(-pi, pi]" if wrapped else f"within ±{end:.4g} {port.unit}".rstrip()
    figures = plan.accuracy.get(port.name)
    bound = "not derived"
    if figures is not None and figures.bound is not None:
        bound = f"{figures.bound.value:.3g} {port.unit}".rstrip()
        if figures.bound.where:
            bound += f" ({figures.bound.where})"
    seen = None if figures is None else figures.observed.max
    return [*_common(port, at), reach, bound, "" if seen is None else f"{seen:.3g} {port.unit}".rstrip()]
