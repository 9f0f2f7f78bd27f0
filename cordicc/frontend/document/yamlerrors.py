"""What the YAML reader complains about, in plain English."""

from __future__ import annotations

import re

from ruamel.yaml.error import MarkedYAMLError

_INDENT = "align this line with the lines above that it belongs to, and check their indentation too"
_QUOTE = "put quotes around a text that starts with a special character"


def explain(error: MarkedYAMLError, text: str) -> tuple[str, str | None]:
    """Return message and hint for an error of the YAML reader in a text."""
    problem = " ".join(str(error.problem or error.context or "syntax error").split())
    mark = error.problem_mark or error.context_mark
    line = _line(text, mark.line) if mark is not None else ""
    before = line[: mark.column] if mark is not None else ""
    if "\\t" in problem or (before.strip() == "" and "\t" in before):
        return "not valid YAML: a tab where only spaces are allowed", (
            "indent with spaces, not with tabs, this line and those above alike"
        )
    if "sequence entries are not allowed" in problem:
        key = re.fullmatch(r"[\s-]*(\w+):\s*", before)
        if key and re.fullmatch(r"-\s*(#.*)?", line[len(before) :]):
            return f"not valid YAML: a lone '-' after '{key[1]}:'", f'put it in quotes: {key[1]}: "-"'
        return "not valid YAML: a list item '-' cannot stand here", (
            "items go on lines of their own, aligned; quote a text that starts with '-'"
        )
    if "expected <block end>" in problem or "<document start>" in problem:
        return "not valid YAML: the indentation of this line does not fit", _INDENT
    if "mapping values are not allowed" in problem:
        if before.count(": ") or re.search(r":\s", before):
            return "not valid YAML: a second ':' in one value", (
                "put quotes around a text that contains ': ', or check the indentation of this line"
            )
        return "not valid YAML: 'key:' cannot stand here", _INDENT
    if "could not find expected ':'" in problem:
        return "not valid YAML: a line above has no ':' after its key", (
            "write 'key: value' with a space after the ':', and check the indentation of the lines above"
        )
    if re.match(r"expected ',' or '[]}]', but got '\['", problem):
        return f"not valid YAML: {problem}", (
            "put quotes around an equation with a vector that is itself inside [ ] or { }"
        )
    if "alias" in problem or "%" in problem or "cannot start any token" in problem:
        return f"not valid YAML: {problem}", _QUOTE
    return f"not valid YAML: {problem}", None


def _line(text: str, number: int) -> str:
    lines = re.split(r"\r\n|\r|\n", text)
    return lines[number] if number < len(lines) else ""
