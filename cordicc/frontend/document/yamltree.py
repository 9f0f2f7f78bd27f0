"""YAML text to a tree of nodes with positions, within limits.

Only the events of the YAML reader are used: no tags are constructed, no aliases expanded, and the
text of a scalar stays what it is in the file.
"""

from __future__ import annotations

import warnings
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceStartEvent,
)
from ruamel.yaml.reader import ReaderError

from cordicc.base.diagnostics import Report, Source, Span
from cordicc.frontend.document.yamlerrors import explain

MAX_BYTES = 1 << 20
MAX_DEPTH = 32
MAX_NODES = 40_000
_MAX_DUPLICATES = 100


class NodeKind(StrEnum):
    """The kinds of nodes."""

    SCALAR = "scalar"
    SEQUENCE = "sequence"
    MAPPING = "mapping"


@dataclass(frozen=True, slots=True, eq=False)
class YamlNode:
    """A node: a scalar's text, a sequence's items, or a mapping's pairs.

    `start` and `end` are offsets into the file; `plain` tells an unquoted scalar; `size` and
    `height` count the node and what is below it, aliases expanded.
    """

    kind: NodeKind
    span: Span
    start: int
    end: int
    value: str = ""
    plain: bool = False
    items: tuple[YamlNode, ...] = ()
    pairs: tuple[tuple[YamlNode, YamlNode], ...] = ()
    size: int = 1
    height: int = 1

    @property
    def is_null(self) -> bool:
        """Whether the node is an empty or null plain scalar."""
        return self.kind is NodeKind.SCALAR and self.plain and self.value in ("", "~", "null", "Null", "NULL")

    @property
    def described(self) -> str:
        """Return what the node is, for messages."""
        if self.is_null:
            return "nothing"
        return {"scalar": "a single value", "sequence": "a list", "mapping": "a mapping"}[self.kind]


class Places:
    """Maps offsets of a text, and of the scalars in it, to lines and columns."""

    def __init__(self, source: Source) -> None:
        self.text = source.text
        self._starts = [0]
        self._aligned: dict[YamlNode, list[int] | None] = {}
        for line in source.text.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def span(self, start: int, end: int) -> Span:
        """Return the span of a stretch of the file, cut at the end of its first line."""
        line = max(0, bisect_right(self._starts, start) - 1)
        column = start - self._starts[line]
        limit = self._starts[line + 1] if line + 1 < len(self._starts) else len(self.text)
        content = len(self.text[self._starts[line] : limit].rstrip("\r\n"))
        end_column = max(column + 1, min(end - self._starts[line], content))
        return Span(line + 1, column + 1, end_column + 1)

    def within(self, node: YamlNode, start: int, end: int) -> Span:
        """Return the span of `node.value[start:end]`, or of the whole node if its text was escaped."""
        offsets = self.offsets(node, start, end)
        return node.span if offsets is None else self.span(*offsets)

    def offsets(self, node: YamlNode, start: int, end: int) -> tuple[int, int] | None:
        """Return where `node.value[start:end]` is in the file, None if its text was escaped."""
        if node not in self._aligned:
            self._aligned[node] = _align(node.value, self.text[node.start : node.end])
        offsets = self._aligned[node]
        if offsets is None:
            return None
        start = min(start, len(offsets) - 1)
        end = max(start + 1, min(end, len(offsets) - 1))
        return node.start + offsets[start], node.start + offsets[end - 1] + 1


def _align(value: str, written: str) -> list[int] | None:
    """Return for each character of a scalar's value its offset in the written form, None if unclear."""
    at = 0
    quote = written[:1] if written[:1] in ("'", '"') else ""
    if quote:
        at = 1
    elif written[:1] in ("|", ">"):
        at = written.find("\n") + 1
    offsets: list[int] = []
    for index, character in enumerate(value):
        if character.isspace():
            offsets.append(min(at, len(written)))
            if at < len(written) and written[at].isspace():
                at += 1
            elif index and not value[index - 1].isspace():
                return None
            continue
        while at < len(written) and written[at].isspace():
            at += 1
        if at >= len(written) or written[at] != character:
            return None
        offsets.append(at)
        at += 2 if quote == "'" and character == "'" else 1
    return [*offsets, at]


@dataclass(slots=True)
class _Open:
    """A collection under construction."""

    event: Any
    anchor: str | None
    items: list[YamlNode]
    size: int = 1
    height: int = 1


class _StopError(Exception):
    """Ends the reading after a diagnostic."""


def read_tree(source: Source, report: Report) -> YamlNode | None:
    """Return the root of a YAML text; None, with diagnostics in `report`, if there is none."""
    places = Places(source)
    if not _check_characters(source.text, places, report):
        return None
    with warnings.catch_warnings(record=True) as remarks:
        warnings.simplefilter("always")
        try:
            root = _TreeBuilder(places, report).build(_events(source.text))
        except _StopError:
            root = None
        except MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            index = mark.index if mark is not None else None
            message, hint = explain(error, source.text)
            span = None if index is None else places.span(index, index + 1)
            report.error("E101", message, span, hint)
            root = None
        except ReaderError as error:
            position = error.position if isinstance(error.position, int) else 0
            report.error("E105", "a character that YAML does not allow", places.span(position, position + 1))
            root = None
        except RecursionError:
            report.error("E104", "the file is nested too deeply")
            root = None
        except Exception as error:  # the reader has its own bugs, e.g. with escapes beyond Unicode
            report.error("E101", f"not readable as YAML ({type(error).__name__})")
            root = None
    for remark in remarks:
        report.warning("W105", " ".join(str(remark.message).split())[:200])
    if root is None and not report.failed:
        report.error(
            "E208", "the file is empty", Span(1, 1, 2), "see the README for the form of a problem file"
        )
    return root


def _events(text: str) -> Iterator[Any]:
    yield from YAML(typ="safe", pure=True).parse(text)


def is_surrogate(character: str) -> bool:
    """Return whether a character is half of a surrogate pair, which no text can hold."""
    return "\ud800" <= character <= "\udfff"


def _check_characters(text: str, places: Places, report: Report) -> bool:
    for index, character in enumerate(text):
        if " " <= character < "\x7f" or character in "\t\n\r":
            continue
        if character < "\xa0" or is_surrogate(character) or character in "\u2028\u2029\ufeff\ufffe\uffff":
            span = places.span(index, index + 1)
            message = f"the file contains the character U+{ord(character):04X}, which is not text"
            hint = "indent with spaces and save the file as UTF-8 without control characters"
            report.error("E105", message, span, hint)
            return False
    return True


class _TreeBuilder:
    def __init__(self, places: Places, report: Report) -> None:
        self.places = places
        self.report = report
        self.stack: list[_Open] = []
        self.anchors: dict[str, YamlNode | None] = {}
        self.root: YamlNode | None = None
        self.total = 0

    def build(self, events: Iterator[Any]) -> YamlNode | None:
        documents = 0
        for event in events:
            if isinstance(event, DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self.stop("E103", "a problem file has one document only", event)
            elif isinstance(event, NodeEvent):
                self.node(event)
            elif self.stack and type(event).__name__ in ("SequenceEndEvent", "MappingEndEvent"):
                self.close(event)
        return self.root

    def stop(self, code: str, message: str, event: Any, hint: str | None = None) -> None:
        self.report.error(code, message, self.places.span(event.start_mark.index, event.end_mark.index), hint)
        raise _StopError

    def node(self, event: Any) -> None:
        if isinstance(event, AliasEvent):
            self.alias(event)
            return
        tag = getattr(event, "tag", None) or getattr(event, "ctag", None)
        if tag is not None and str(tag) not in ("", "None"):
            self.stop("E103", f"tags such as {str(tag)[:60]!r} are not supported", event)
        if isinstance(event, ScalarEvent):
            start, end = event.start_mark.index, event.end_mark.index
            start = self.after_anchor(event, start)
            lone = next(filter(is_surrogate, event.value), None)
            if lone is not None:
                message = f"the text contains U+{ord(lone):04X}, half of a surrogate pair"
                self.stop("E105", message, event, "write the character itself")
            plain = not event.style
            node = YamlNode(NodeKind.SCALAR, self.places.span(start, end), start, end, event.value, plain)
            self.finish(node, event.anchor, event)
        elif isinstance(event, SequenceStartEvent | MappingStartEvent):
            if len(self.stack) >= MAX_DEPTH:
                self.stop("E104", f"the file is nested more than {MAX_DEPTH} deep", event)
            if event.anchor is not None:
                self.anchors[event.anchor] = None
            self.stack.append(_Open(event, event.anchor, []))

    def after_anchor(self, event: Any, start: int) -> int:
        """Return where the text of an anchored scalar starts."""
        if event.anchor is not None and self.places.text.startswith("&", start):
            start += 1 + len(event.anchor)
            while self.places.text[start : start + 1].isspace():
                start += 1
        return start

    def alias(self, event: Any) -> None:
        name = event.anchor
        if name not in self.anchors:
            hint = "put quotes around a text that starts with '*'"
            self.stop("E101", f"the alias '*{name}' has no anchor", event, hint)
        node = self.anchors[name]
        if node is None:
            self.stop("E103", f"the alias '*{name}' is inside its own anchor", event)
        assert node is not None
        if len(self.stack) + node.height > MAX_DEPTH:
            self.stop("E104", f"the file is nested more than {MAX_DEPTH} deep", event)
        self.finish(node, None, event)

    def close(self, event: Any) -> None:
        opened = self.stack.pop()
        start, end = opened.event.start_mark.index, event.end_mark.index
        span = self.places.span(start, max(end, start + 1))
        if isinstance(opened.event, SequenceStartEvent):
            node = YamlNode(NodeKind.SEQUENCE, span, start, end, items=tuple(opened.items))
        else:
            node = YamlNode(NodeKind.MAPPING, span, start, end, pairs=self.pairs(opened.items))
        node = replace(node, size=opened.size, height=opened.height)
        self.finish(node, opened.anchor, event)

    def pairs(self, items: list[YamlNode]) -> tuple[tuple[YamlNode, YamlNode], ...]:
        """Return keys with values; report keys that are not scalars, and duplicates."""
        found: dict[str, YamlNode] = {}
        pairs = []
        for key, value in zip(items[::2], items[1::2], strict=True):
            if key.kind is not NodeKind.SCALAR:
                self.report.error("E103", f"a key must be a name, not {key.described}", key.span)
                continue
            first = found.get(key.value)
            if first is not None:
                if len(self.report.diagnostics) >= _MAX_DUPLICATES:
                    continue
                message = f"the key '{key.value}' occurs twice, first on line {first.span.line}"
                self.report.error("E102", message, key.span)
                continue
            found[key.value] = key
            if value.start >= value.end:
                value = replace(value, span=key.span)  # the reader places an absent value at the next token
            pairs.append((key, value))
        return tuple(pairs)

    def finish(self, node: YamlNode, anchor: str | None, event: Any) -> None:
        if anchor is not None:
            self.anchors[anchor] = node
        if not self.stack:
            self.root = node
            return
        parent = self.stack[-1]
        parent.items.append(node)
        parent.size += node.size
        parent.height = max(parent.height, node.height + 1)
        # what is still open counts too: only so does every prefix of the file stay within the limit
        if sum(opened.size for opened in self.stack) > MAX_NODES:
            self.stop("E104", f"the file has more than {MAX_NODES} nodes, aliases expanded", event)
