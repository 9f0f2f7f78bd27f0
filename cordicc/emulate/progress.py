"""How far a long run has come, on stderr: one line that changes on a terminal, a line now and then else."""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import monotonic

_QUIET_SECONDS = 2.0
_TERMINAL_SECONDS = 0.5
_PLAIN_SECONDS = 15.0


class Progress:
    """Counts samples; says nothing in a run of less than two seconds."""

    def __init__(self, total: int | None, clock: Callable[[], float] = monotonic) -> None:
        self._total, self._clock = total, clock
        self._terminal = sys.stderr.isatty()
        self._next = clock() + (_QUIET_SECONDS if self._terminal else _PLAIN_SECONDS)
        self._width = 0

    def reached(self, samples: int) -> None:
        """Tell how many samples are done."""
        if self._clock() < self._next:
            return
        self._next = self._clock() + (_TERMINAL_SECONDS if self._terminal else _PLAIN_SECONDS)
        of = "" if self._total is None else f" of {self._total:,}"
        text = f"{samples:,}{of} samples"
        end = "" if self._terminal else "\n"
        sys.stderr.write(("\r" if self._terminal else "") + text.ljust(self._width) + end)
        sys.stderr.flush()
        self._width = len(text) if self._terminal else 0

    def done(self) -> None:
        """Wipe the line from a terminal."""
        if self._width:
            sys.stderr.write("\r" + " " * self._width + "\r")
            sys.stderr.flush()
            self._width = 0
