"""Results in a folder: written whole, and over nobody's own files."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path

from cordicc.backends.escaping import quoted
from cordicc.backends.pictures.svg import FONT
from cordicc.backends.script import text_for
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.base.files import MAX_BYTES, read_bytes
from cordicc.base.folders import write_files
from cordicc.base.seals import is_csv, is_sealed, vouches, was_sealed

_HEAD_BYTES = 4096


def write_results(folder: Path, files: Mapping[str, str], *, force: bool = False) -> None:
    """Write files into a folder, all at once or none; what else is in it stays.

    Raises:
        InvalidInput: one of them is there, and cordicc did not make it (E604, never with `force`); the folder
            cannot be written (E600).
    """
    write_files(folder, files, None if force else lambda: require_own(folder, files))


def require_own(folder: Path, names: Iterable[str]) -> None:
    """Raise InvalidInput (E604) for each file of a folder that cordicc did not make, or somebody changed."""
    there = (path for path in map(folder.joinpath, names) if os.path.lexists(path) and not path.is_dir())
    others = [path for path in there if not _is_own(path)]
    if others:
        message = "cordicc did not make this file, or it was changed since"
        hint = "name another folder with -o, move the file away, or replace it: --force"
        raise InvalidInput(Diagnostic("E604", message, hint=hint, source=Source(str(p), "")) for p in others)


def _is_own(path: Path) -> bool:
    """Tell whether cordicc made a file as it is; links are the user's."""
    if path.is_symlink() or not path.is_file():
        return False
    data = _content(path)
    if data is not None and is_csv(path.name):
        described = _content(path.with_suffix(".json"))
        return described is not None and vouches(described, data)
    if data is None or is_sealed(path.name, data):
        return data is not None
    plan = _content(path.parent / "plan.json")
    if was_sealed(data) or plan is None or not is_sealed("plan.json", plan):
        return False
    return _is_unmarked_result(path.name, data, str(json.loads(plan).get("name")))


def _content(path: Path) -> bytes | None:
    """Return what a file holds, None if it cannot be read or is larger than any of cordicc's."""
    try:
        data = read_bytes(path, MAX_BYTES)
    except (OSError, ValueError):
        return None
    return data if len(data) <= MAX_BYTES else None


def _is_unmarked_result(name: str, data: bytes, plan_name: str) -> bool:
    """Tell whether a file is a result from before results were marked, beside the plan of that name.

    It is known by what it begins with; the script, which people change, by its whole text, and C models,
    which they change too, not at all.
    """
    if name == "simulate.py":
        return data.replace(b"\r\n", b"\n") == text_for(plan_name).encode()
    head = data[:_HEAD_BYTES].decode("utf-8", "replace")
    if name == "report.html":
        return (
            head.startswith("<!DOCTYPE html>")
            and f"<title>{escape(plan_name)}: cordicc report</title>" in head
        )
    label = rf'aria-label="(?:Datapath|Schedule|Trade-off) of {re.escape(quoted(plan_name))}[^"]*"'
    font = re.escape(escape(FONT, quote=False))
    return (
        name.endswith(".svg")
        and re.match(rf'<svg xmlns="[^"]*" [^>]*{label} font-family="{font}">', head) is not None
    )
