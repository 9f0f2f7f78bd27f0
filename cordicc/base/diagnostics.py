"""Source positions, diagnostics with stable codes, and how they are shown.

A mistake of the user is a `Diagnostic`; a stage collects all it can find in a `Report` and raises
them together.  A mistake of the compiler is an assertion.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum


class Severity(StrEnum):
    """An error ends the run; a warning does not."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A stretch of one line of a source text: 1-based line, 1-based columns, end exclusive."""

    line: int
    column: int
    end_column: int


@dataclass(frozen=True, slots=True)
class Source:
    """A text and the name under which the user knows it."""

    name: str
    text: str

    def line(self, number: int) -> str:
        """Return line `number` (1-based) without its end, or the empty string past the end."""
        lines = self.text.splitlines()
        return lines[number - 1] if 0 < number <= len(lines) else ""


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding: a stable code, what is wrong, where, and what would help."""

    code: str
    message: str
    span: Span | None = None
    hint: str | None = None
    severity: Severity = Severity.ERROR
    source: Source | None = None

    def render(self) -> str:
        """Return the text shown to the user, without a final newline."""
        message = self.message
        if len(message) > _LONGEST_MESSAGE:
            message = f"{message[:_LONGEST_MESSAGE]}..."
        head = f"{self.severity}[{self.code}]: {printable(message)}"
        place = printable(self.source.name) if self.source is not None else ""
        if self.source is not None and self.span is not None:
            place += f":{self.span.line}:{self.span.column}"
        lines = [f"{place}: {head}" if place else head]
        if self.source is not None and self.span is not None:
            lines += _excerpt(self.source.line(self.span.line), self.span)
        if self.hint:
            lines.append(f"  hint: {printable(self.hint)}")
        return "\n".join(lines)


_EXCERPT_COLUMNS = 100
_LONGEST_MESSAGE = 1000
"""Characters, as names and texts of a file may be long."""


def _excerpt(line: str, span: Span) -> list[str]:
    """Return the source line, shortened around the span, and a line of carets under it."""
    start = max(0, min(span.column - 1, len(line)))
    end = max(start + 1, min(span.end_column - 1, len(line)))
    first = max(0, start - _EXCERPT_COLUMNS // 2) if len(line) > _EXCERPT_COLUMNS else 0
    shown = line[first : first + _EXCERPT_COLUMNS]
    end = min(end, first + len(shown) + 1)
    lead = "..." if first else ""
    trail = "..." if first + len(shown) < len(line) else ""
    caret = " " * (start - first + len(lead)) + "^" * max(1, end - start)
    return [f"    {lead}{printable(shown)}{trail}", f"    {caret}"]


def printable(text: str) -> str:
    """Replace every control or unprintable character by `?`.

    Such text cannot drive a terminal, and as surrogates count as unprintable it can be encoded in UTF-8.
    """
    return "".join(c if c.isprintable() else ("\n" if c == "\n" else "?") for c in text)


class CordiccError(Exception):
    """A problem that ends the run: its diagnostics and the exit status of the command line.

    `warnings` are those that came up before, which are told first.
    """

    exit_status = 2

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        self.warnings: tuple[Diagnostic, ...] = ()
        super().__init__("\n".join(d.render() for d in self.diagnostics))


class InvalidInput(CordiccError):
    """The file, the options or the problem is invalid (exit status 2)."""


class Unattainable(CordiccError):
    """The problem is valid but no plan within the limits meets it (exit status 1)."""

    exit_status = 1


@dataclass(slots=True)
class Report:
    """Collects the diagnostics of one source."""

    source: Source | None = None
    diagnostics: list[Diagnostic] = field(default_factory=list)
    errors: int = 0
    _seen: set[Diagnostic] = field(default_factory=set)

    def error(self, code: str, message: str, span: Span | None = None, hint: str | None = None) -> None:
        """Record an error."""
        self._add(Diagnostic(code, message, span, hint, Severity.ERROR, self.source))

    def warning(self, code: str, message: str, span: Span | None = None, hint: str | None = None) -> None:
        """Record a warning."""
        self._add(Diagnostic(code, message, span, hint, Severity.WARNING, self.source))

    def _add(self, diagnostic: Diagnostic) -> None:
        if diagnostic not in self._seen:
            self._seen.add(diagnostic)
            self.diagnostics.append(diagnostic)
            self.errors += diagnostic.severity is Severity.ERROR

    @property
    def failed(self) -> bool:
        """Whether an error was recorded."""
        return self.errors > 0

    def ordered(self) -> list[Diagnostic]:
        """Return the diagnostics by place, those without a place last."""
        far = Span(1 << 60, 0, 0)
        return sorted(self.diagnostics, key=lambda d: d.span or far)

    def first(self, limit: int) -> list[Diagnostic]:
        """Return at most `limit` of the diagnostics by place; warnings give way to errors."""
        ranked = sorted(self.ordered(), key=lambda d: d.severity is Severity.WARNING)
        far = Span(1 << 60, 0, 0)
        return sorted(ranked[:limit], key=lambda d: d.span or far)

    def raise_if_failed(self) -> None:
        """Raise `InvalidInput` with everything recorded if an error is among it."""
        if self.failed:
            raise InvalidInput(self.ordered())
