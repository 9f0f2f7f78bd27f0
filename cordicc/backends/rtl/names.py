"""Names and comments in Verilog."""

from __future__ import annotations

from collections.abc import Iterable

from cordicc.backends.identifiers import unique_identifiers

_RESERVED = """
    always and assign automatic begin buf bufif0 bufif1 case casex casez cell cmos config deassign default
    defparam design disable edge else end endcase endconfig endfunction endgenerate endmodule endprimitive
    endspecify endtable endtask event for force forever fork function generate genvar highz0 highz1 if ifnone
    incdir include initial inout input instance integer join large liblist library localparam macromodule
    medium module nand negedge nmos nor noshowcancelled not notif0 notif1 or output parameter pmos posedge
    primitive pull0 pull1 pulldown pullup pulsestyle_onevent pulsestyle_ondetect rcmos real realtime reg
    release repeat rnmos rpmos rtran rtranif0 rtranif1 scalared showcancelled signed small specify specparam
    strong0 strong1 supply0 supply1 table task time tran tranif0 tranif1 tri tri0 tri1 triand trior trireg
    unsigned use uwire vectored wait wand weak0 weak1 while wire wor xnor xor
    alias assert assume before bind bins binsof bit break byte chandle checker class clocking const constraint
    context continue cover cross dist do endclass enum expect export extends extern final first_match foreach
    forkjoin global iff ignore_bins illegal_bins import inside int interface intersect let local logic longint
    matches modport new nexttime null package packed priority program property protected pure rand randc
    ref restrict return sequence shortint shortreal solve static string strong struct super tagged this
    throughout timeprecision timeunit type typedef union unique var virtual void weak with within
    clk ce rst rst_n arst arst_n slot in_valid in_ready out_valid out_ok"""
_KEYWORDS = frozenset(_RESERVED.split())
"""Of Verilog and of SystemVerilog, and the ports that every core has."""


def identifiers(names: Iterable[str]) -> dict[str, str]:
    """Return a Verilog identifier for each name, all different: the name itself where Verilog allows it."""
    return unique_identifiers(names, _KEYWORDS.__contains__)


def stem(name: str) -> str:
    """Return what the names of all modules and files of a plan begin with; more always follows."""
    return unique_identifiers([name], lambda _: False)[name]


def comment(text: str) -> str:
    """Return text that can stand behind `//`, on one line."""
    return " ".join("".join(c if c.isprintable() and c.isascii() else " " for c in text).split()).rstrip("\\")
