"""How a core is reset: its port says it, `a` for asynchronous, `_n` for active low."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ResetStyle:
    """A style of reset, by the name of its port at the core."""

    port: str

    @property
    def asynchronous(self) -> bool:
        """Whether it acts without a clock edge."""
        return self.port.startswith("a")

    @property
    def active_low(self) -> bool:
        """Whether 0 resets."""
        return self.port.endswith("_n")

    @property
    def active(self) -> str:
        """The expression that is true while it resets."""
        return f"!{self.port}" if self.active_low else self.port

    @property
    def about(self) -> str:
        """Say it in words."""
        return f"{self.timing}, active {'low' if self.active_low else 'high'}"

    @property
    def timing(self) -> str:
        """Say when it acts."""
        return "asynchronous" if self.asynchronous else "synchronous"

    @property
    def edges(self) -> str:
        """What registers that are reset wait for."""
        return f"posedge clk{self._also(self.port, self.active_low)}"

    @property
    def stream_edges(self) -> str:
        """The same of the stream, whose reset is `aresetn` in any style."""
        return f"posedge aclk{self._also('aresetn', True)}"

    def driven_by(self, active_high: str) -> str:
        """Return what drives the port where a signal resets that is active high."""
        return f"!{active_high}" if self.active_low else active_high

    def _also(self, port: str, low: bool) -> str:
        if not self.asynchronous:
            return ""
        return f" or {'negedge' if low else 'posedge'} {port}"


RESETS = {port: ResetStyle(port) for port in ("rst", "rst_n", "arst", "arst_n")}
"""The styles by the names of their ports."""

USUAL_RESET = RESETS["rst"]
