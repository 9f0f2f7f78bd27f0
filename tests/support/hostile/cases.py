"""What a hostile case is."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

Content = str | bytes


@dataclass(frozen=True)
class Case:
    """A command on files that somebody made to break it, and how it has to end.

    Without `codes` it succeeds; else it fails and tells one of them, or may also succeed if "ok" is among
    them.  `prepare` makes what text alone cannot: links, pipes, folders.
    """

    name: str
    arguments: tuple[str, ...]
    files: Mapping[str, Content | Callable[[], Content]] = field(default_factory=dict)
    codes: tuple[str, ...] = ()
    prepare: Callable[[Path], None] | None = None

    def fits(self, status: int, told: Collection[str]) -> bool:
        """Tell whether the command may end with a status, after telling errors of some codes."""
        if status == 0:
            return not self.codes or "ok" in self.codes
        return status in (1, 2) and not set(told).isdisjoint(self.codes)

    def lay_out(self, folder: Path) -> None:
        """Write the files."""
        for name, given in self.files.items():
            content = given() if callable(given) else given
            data = content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass")
            (folder / name).write_bytes(data)
        if self.prepare is not None:
            self.prepare(folder)


def compiling(name: str, text: Content, *codes: str, options: tuple[str, ...] = ()) -> Case:
    """Return the case of compiling a problem file."""
    return Case(name, ("compile", "p.yaml", "-o", "out", "-q", *options), {"p.yaml": text}, codes)
