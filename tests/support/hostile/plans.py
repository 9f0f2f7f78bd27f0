"""Hostile plans: one that was compiled, with something in it replaced."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from tests.support.hostile.cases import Case

PROBLEM = """
name: small
inputs: {x: [0.25, 0.5], a: [-1, 1]}
equations:
  - z = x*cos(a) + 0.1
  - b = x*a
"""
COMMANDS = {
    "simulate": ("simulate", "plan.json", "--random", "100"),
    "cycle by cycle": ("simulate", "plan.json", "--random", "3", "--cycle-accurate"),
    "draw": ("draw", "plan.json", "-o", "o.svg"),
}

Data = dict[str, Any]


@cache
def plan() -> str:
    """Return the text of a plan."""
    import cordicc

    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "small.yaml"
        path.write_text(PROBLEM, encoding="utf-8")
        return cordicc.compile(path).to_json()


def data() -> Data:
    found: Data = json.loads(plan())
    return found


def changed(change: Callable[[Data], object]) -> str:
    made = data()
    change(made)
    return json.dumps(made)


def program(lines: int, operation: str = "mul(%{0}, %{0})") -> str:
    """Return the equations of the plan with many operations in front of them."""

    def change(made: Data) -> None:
        written = made["problem"]["program"].splitlines()
        outputs = [line for line in written if line.startswith("output")]
        nodes = [line for line in written if not line.startswith("output")]
        count = len(nodes)
        nodes += [f"%{i} = {operation.format(i - 1)}" for i in range(count, count + lines)]
        made["problem"]["program"] = "\n".join([*nodes, *outputs]) + "\n"

    return changed(change)


def operations_in_a_circle(made: Data) -> None:
    first = next(o for o in made["operations"] if any(o["results"]))
    result = next(name for name in first["results"] if name)
    first["operands"][0] = {"value": result}


CHANGES: dict[str, Callable[[], str | bytes]] = {
    "deep lists": lambda: "[" * 100_000,
    "deep objects": lambda: '{"a": ' * 50_000,
    "a key twice": lambda: '{"format": "x", ' + plan().lstrip()[1:],
    "half a plan": lambda: plan()[: len(plan()) // 2],
    "Latin-1": lambda: plan().encode().replace(b"small", b"sm\xe9ll"),
    "100,000 operations": lambda: changed(lambda d: d["operations"].extend([d["operations"][0]] * 100_000)),
    "one operation twice": lambda: changed(lambda d: d["operations"].append(d["operations"][0])),
    "20,000 units": lambda: changed(
        lambda d: d["units"].extend({**d["units"][0], "id": f"u{i}"} for i in range(19_000))
    ),
    "an operation on itself": lambda: changed(operations_in_a_circle),
    "a FIFO of 10^9 words": lambda: changed(lambda d: d["fifos"][0].update(depth=10**9)),
    "50 FIFOs of a million words": lambda: changed(
        lambda d: d["fifos"].extend({**d["fifos"][0], "id": f"g{i}", "depth": 10**6} for i in range(50))
    ),
    "a clock of 10^400": lambda: plan().replace("10000000.0", "1" + "0" * 400).replace("10000000,", "1e400,"),
    "a latency of 10^12": lambda: changed(lambda d: d["latency"].update(cycles=10**12)),
    "a negative latency": lambda: changed(lambda d: d["latency"].update(cycles=-1)),
    "a program of a million operations": lambda: program(1_000_000),
    "a program that doubles": lambda: program(19_000, "add(%{0}, %{0})"),
    "a program of exponentials": lambda: program(300, "exp(%{0})"),
    "a program of solves": lambda: program(15_000, "solve[m=1, branch=+](%{0}, %{0}, %{0})"),
    "a program of huge powers": lambda: program(10, "pow[exponent=" + "9" * 900 + "](%{0})"),
    "a program of huge shifts": lambda: program(10, "shift[exponent=" + "9" * 900 + "](%{0})"),
    "an unknown operation": lambda: program(1, "__import__(%{0})"),
    "ranges of 1e308": lambda: changed(lambda d: d["problem"]["inputs"][0].update(lo=-1e308, hi=1e308)),
    "10,000 columns of samples": lambda: changed(
        lambda d: d["problem"].update(samples={"columns": {f"x{i}": [0.5] * 100 for i in range(10_000)}})
    ),
    "ragged samples": lambda: changed(
        lambda d: d["problem"].update(samples={"columns": {"x": [0.5] * 1000, "a": [0.5]}})
    ),
    "a target of a million stages": lambda: changed(
        lambda d: d["target_data"]["arithmetic"]["units"]["standard"].update(iterations=10**6)
    ),
    "words of a million bits": lambda: changed(
        lambda d: d["target_data"]["arithmetic"].update(format={"kind": "fixed-point", "width": 10**6})
    ),
    "a factor of a megabyte": lambda: changed(
        lambda d: next(o["params"] for o in d["operations"] if o["op"] == "mul").update(factor="1" * 10**6)
    ),
    "markup everywhere": lambda: plan().replace('"small"', '"</text><script>alert(1)</script>"'),
    "a name that drives a terminal": lambda: plan().replace('"small"', '"\\u001b[2J\\u202e"'),
}  # fmt: skip

WELL_FORMED = ("markup everywhere", "a name that drives a terminal", "ranges of 1e308")
"""Changes that leave a plan that can be run."""


def writer(make: Callable[[], str | bytes]) -> Callable[[Path], None]:
    """Return what writes a changed plan into a folder."""

    def write(folder: Path) -> None:
        content = make()
        encoded = content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass")
        (folder / "plan.json").write_bytes(encoded)

    return write


CASES = [
    Case(f"{command}: {name}", arguments, {}, ("ok", "E600", "E601", "E602", "E603"), writer(make))
    for name, make in CHANGES.items()
    for command, arguments in COMMANDS.items()
]
