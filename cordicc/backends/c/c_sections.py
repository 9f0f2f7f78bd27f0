"""Templates of the C model: rendering, and picking the functions that a plan needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from cordicc.backends.plain_templates import plain_templates

_MARK = "//@ "


@dataclass(frozen=True, slots=True)
class Section:
    """A piece of C and the names of the sections that it needs."""

    needs: tuple[str, ...]
    text: str


@dataclass(slots=True)
class Library:
    """Sections by name; those of a unit carry its prefix and may need any other."""

    sections: dict[str, Section] = field(default_factory=dict)

    def add(self, template: str, prefix: str, context: Mapping[str, Any]) -> None:
        """Add the sections of a template."""
        chunks = render(template, context).split(f"\n{_MARK}")[1:]  # before the first: what the file is
        heads = [chunk.partition("\n")[0].partition(":") for chunk in chunks]
        own = {name for name, _, _ in heads}
        for (name, _, needs), chunk in zip(heads, chunks, strict=True):
            full = tuple(prefix + need if need in own else need for need in needs.split())
            self.sections[prefix + name] = Section(full, chunk.partition("\n")[2].strip("\n"))

    def text(self, roots: Iterable[str]) -> str:
        """Return the sections needed, each after what it needs."""
        done: dict[str, str] = {}

        def visit(name: str) -> None:
            if name not in done:
                section = self.sections[name]
                for need in section.needs:
                    visit(need)
                done[name] = section.text

        for root in roots:
            visit(root)
        return "\n\n".join(done.values())


def render(template: str, context: Mapping[str, Any]) -> str:
    """Return a template's text."""
    return plain_templates("cordicc.backends.c").get_template(template).render(i64=int64, **context)


def int64(number: int) -> str:
    """Write a constant of 64 bits."""
    return f"INT64_C({number})" if number >= 0 else f"-INT64_C({-number})"
