"""The mark by which cordicc knows the files that it made: a comment at the end of each.

It holds a hash of the lines above it, so that a file that somebody has changed since is no longer taken for
one.  JSON has no comments; a file of cordicc's says what it is under the key `format`.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import PurePosixPath

_MARKUP, _HASH, _SLASHES, _STARS = ("<!-- ", " -->"), ("# ", ""), ("// ", ""), ("/* ", " */")
_COMMENTS = {
    ".c": _STARS, ".h": _STARS, ".css": _STARS,
    ".html": _MARKUP, ".md": _MARKUP, ".svg": _MARKUP, ".xml": _MARKUP,
    ".core": _HASH, ".lpf": _HASH, ".mk": _HASH, ".pcf": _HASH, ".py": _HASH, ".sby": _HASH, ".sdc": _HASH,
    ".sh": _HASH, ".tcl": _HASH, ".toml": _HASH, ".xdc": _HASH, ".yaml": _HASH, ".yml": _HASH, ".ys": _HASH,
    "Makefile": _HASH,
    ".cpp": _SLASHES, ".hex": _SLASHES, ".mem": _SLASHES, ".sv": _SLASHES, ".svh": _SLASHES, ".v": _SLASHES,
    ".vh": _SLASHES,
}  # fmt: skip
"""What comments begin and end with, by the end of a file's name or all of it."""

_SAID = "made by cordicc; SHA-256 of the lines above: "


def sealed(name: str, text: str) -> str:
    """Return the text of a file, which ends with a line's end, with the mark.

    Raises:
        ValueError: it is not known how files of that name are marked.
    """
    if _is_json(name) or is_csv(name):
        return text
    return text + _mark(name, text.encode())


def is_sealed(name: str, data: bytes) -> bool:
    """Tell whether a file has the mark of cordicc, or is JSON of cordicc's; line ends may have changed."""
    if _is_json(name):
        return _is_own_json(data)
    lines = data.replace(b"\r\n", b"\n")
    above = lines.rfind(b"\n", 0, -1) + 1
    return lines[above:] == _mark(name, lines[:above]).encode()


def was_sealed(data: bytes) -> bool:
    """Tell whether a file has, or had, the mark."""
    return _SAID.encode() in data


def _mark(name: str, above: bytes) -> str:
    path = PurePosixPath(name)
    if (path.suffix or path.name) not in _COMMENTS:
        raise ValueError(f"it is not known how '{name}' is marked as made by cordicc")
    begin, end = _COMMENTS[path.suffix or path.name]
    return f"{begin}{_SAID}{hashlib.sha256(above).hexdigest()}{end}\n"


def is_csv(name: str) -> bool:
    """Tell whether a file has no room for a mark, so that `vouches` tells whether it is cordicc's."""
    return name.endswith(".csv")


def vouches(described: bytes, data: bytes) -> bool:
    """Tell whether a JSON file is cordicc's and has the hash of a CSV file; line ends may have changed."""
    if not _is_own_json(described):
        return False
    digest = hashlib.sha256(data.replace(b"\r\n", b"\n")).hexdigest()
    return bool(json.loads(described).get("csv_sha256") == digest)


def _is_json(name: str) -> bool:
    return name.endswith(".json")


def _is_own_json(data: bytes) -> bool:
    try:
        content = json.loads(data)
    except (ValueError, RecursionError):
        return False
    return isinstance(content, dict) and str(content.get("format")).startswith("cordicc-")
