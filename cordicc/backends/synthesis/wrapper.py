"""A top for a core that needs four pins: its words come from a shift register, and leave through one.

A chip has fewer pins than a core has bits.  The registers stand right at the ports of the core, so that all
paths within it, from its inputs on, are between registers.
"""

from __future__ import annotations

from collections.abc import Iterator

from cordicc.backends.rtl.core import Core

TOP = "synthesis_top"
INSTANCE = "core"


def wrapper_text(core: Core) -> str:
    """Return the module around a core, and the core as a black box."""
    return "\n".join([*_black_box(core), "", *_top(core)]) + "\n"


def _ports(core: Core) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """Return inputs and outputs with their bits, but for the clock and the reset."""
    ready = [("in_ready", 1)] if core.interval > 1 else []
    ins = [("ce", 1), ("in_valid", 1), *((port.port, port.format.width_bits) for port in core.inputs)]
    outs = [*ready, ("out_valid", 1), ("out_ok", 1)]
    return ins, [*outs, *((port.port, port.format.width_bits) for port in core.outputs)]


def _black_box(core: Core) -> Iterator[str]:
    ins, outs = _ports(core)
    declared = [f"    input wire [{width - 1}:0] {name}" for name, width in [("clk", 1), ("rst", 1), *ins]]
    declared += [f"    output wire [{width - 1}:0] {name}" for name, width in outs]
    yield "(* blackbox *)"
    yield f"module {core.name}_core ("
    yield ",\n".join(declared)
    yield ");"
    yield "endmodule"


def _top(core: Core) -> Iterator[str]:
    ins, outs = _ports(core)
    taken, given = (sum(width for _, width in ports) for ports in (ins, outs))
    yield f"module {TOP} (input wire clk, input wire rst, input wire in_bit, output wire out_bit);"
    yield f"    reg [{taken - 1}:0] taken;"
    yield f"    always @(posedge clk) taken <= {{taken[{taken - 2}:0], in_bit}};"
    for name, width in outs:
        yield f"    wire [{width - 1}:0] core_{name};"
    yield f"    {core.name}_core {INSTANCE} ("
    yield "        .clk(clk), .rst(rst),"
    at, wired = 0, []
    for name, width in ins:
        wired.append(f"        .{name}(taken[{at + width - 1}:{at}])")
        at += width
    wired += [f"        .{name}(core_{name})" for name, _ in outs]
    yield ",\n".join(wired)
    yield "    );"
    words = ", ".join(f"core_{name}" for name, _ in outs)
    yield f"    reg [{given - 1}:0] given;"
    yield "    always @(posedge clk)"
    yield f"        given <= core_out_valid ? {{{words}}} : {{given[{given - 2}:0], 1'b0}};"
    yield f"    assign out_bit = given[{given - 1}];"
    yield "endmodule"
