"""Writes the pages and pictures of this folder that follow from the program: `python docs/generate.py`.

A test fails if one of them is not what this script makes.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cordicc import artefacts, pipeline
from cordicc.backends.labels import headline
from cordicc.backends.pictures.diagram import PAGE_WIDTH
from cordicc.base.codes import CODES, HELP, UNATTAINABLE
from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.frontend.load import parse_problem
from cordicc.plan.file import schema

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"

_GROUPS = {
    "1": "Reading a problem file, syntax of expressions",
    "2": "Names, values and sections of a problem file",
    "3": "`solve`, vectors, and the domain of the equations",
    "4": "Plans that cannot be made",
    "5": "Targets",
    "6": "Files, samples and plans",
    "7": "`cordicc trace` and `cordicc sequences`",
    "8": "`cordicc schedule`",
}
_EXAMPLE = """\
constants: {l1: 0.4, l2: 0.3}
inputs: {x: [0, 0.5]}
equations:
  - y = l1 + l2*cos(l3*x)
"""
_HEAD = """# Diagnostics

Every error and warning has a code that stays the same from version to version:

```
{example}
```

All that can be found in one go are listed, by place. Errors (E) end the run with exit status 2, or 1 where
the problem is valid but no plan meets it (marked below); warnings (W) do not.

This page is written by `python docs/generate.py` from `cordicc/base/codes.py`.
"""


def diagnostics_page() -> str:
    """Return the reference of all codes, by hundreds."""
    parts = [_HEAD.format(example=_example())]
    for digit, title in _GROUPS.items():
        parts.append(f"\n## {title}\n\n| code | meaning | what to do |\n|---|---|---|\n")
        codes = sorted((code for code in CODES if code[1] == digit), key=lambda code: (code[0], code))
        parts += [f"| {_marked(code)} | {_plain(CODES[code])} | {_plain(HELP[code])} |\n" for code in codes]
    return "".join(parts)


def _marked(code: str) -> str:
    return f"{code}, exit 1" if code in UNATTAINABLE else code


def _plain(text: str) -> str:
    """Return a text of which Markdown takes no character for markup."""
    return re.sub(r"([*_<>\[\]`|])", r"\\\1", text)


def _example() -> str:
    try:
        parse_problem(Source("arm.yaml", _EXAMPLE))
    except InvalidInput as error:
        return str(error)
    raise AssertionError("the example has no mistake")


_GALLERY_HEAD = """# Gallery

The examples of `examples/` on the default target, each with the datapath of its plan.

This page and its pictures are written by `python docs/generate.py`.
"""


def gallery() -> dict[Path, str]:
    """Return the page of the examples and their pictures, by path."""
    made: dict[Path, str] = {}
    page = [_GALLERY_HEAD]
    for example in sorted((ROOT / "examples").glob("*.yaml")):
        plan = pipeline.plan_file(example, pipeline.Options()).plan
        made[DOCS / "gallery" / f"{example.stem}.svg"] = artefacts.picture(plan, "datapath", PAGE_WIDTH)
        text = " ".join(plan.description.split())
        page.append(
            f"\n## {plan.name}\n\n"
            + (f"{_plain(text)}\n\n" if text else "")
            + f"[examples/{example.name}](../examples/{example.name}): {_plain(headline(plan))}\n\n"
            f"![Datapath of {plan.name}](gallery/{example.stem}.svg)\n"
        )
    made[DOCS / "gallery.md"] = "".join(page)
    return made


_PLAN_HEAD = """# The plan file

`cordicc compile` writes `plan.json`, complete enough to simulate and draw it, and to build the hardware from.
`cordicc schema plan` prints the JSON Schema that this page is made of. `[]` stands for each member of a
list, `*` for each name.

| field | what it is |
|---|---|
"""


_HARDWARE = """
## Words in hardware

What `--emit verilog` writes, and what hardware by others has to do to have the same bits on a fixed-point
target. What a CORDIC unit does in between, from the integers under `cordic`, stands in
[units in integers](units.md).

- **Words** are in two's complement: w stands for w · 2^-fraction, with `width` and `fraction` of
  `formats.values` (inputs and results, by name) and `formats.outputs` (what is delivered). Constants
  (`operations[].operands[].constant`, the `factor` of a product in `operations[].params`) have as many
  fraction bits as let a word of the `width` plus `guard` of `target_data.arithmetic.format` hold them,
  rounded to nearest, ties to even.
- **Invalid words.** The least code, 1 0…0, stands for no number; so words are symmetric, ±(2^(width-1) -
  1). Any invalid operand makes all results of an operation invalid. Inside, a bit beside each word does as
  well: then the code matters at the ports alone, and what an operation makes of invalid operands does not
  matter.
- **Inputs**: the words from lo · 2^fraction to hi · 2^fraction, both rounded like results (`problem.inputs`),
  are in range; any other one is invalid, and so is the sample, even if nothing takes the input. The ends
  are those of the rounded words.
- **Rounding**: the shifts of a unit round half up, but for the few that [its page](units.md) says cut; its
  result, or that of an addition or product, which is exact, is rounded once to the format of the result, as
  `target_data.arithmetic.format.rounding` says (half-up: add half of the last place and cut). A word that
  leaves its format is invalid: nothing saturates, nothing wraps around.
- **Outputs** whose format differs from that of the value they take (`outputs`) are rounded once more, in no
  cycle of their own. A sample is valid if all its outputs are; if it is not, each of them is the invalid
  word.
- **Angles** are in radians. A result that is an angle (`outputs.*.angle`, the angle of a unit) of at most
  π, before it is rounded or within a quarter of the last place, is no word beyond π: the largest is floor(π
  · 2^fraction). `wrap` brings an angle into (-π, π] by multiples of a 2π with 27 fraction bits more than
  the angle.
- **Slots.** A sample enters in slot 0; cycle c of it is slot c modulo `initiation_interval`. An operation
  takes its operands in cycle `start` and its results are there from `finish` on. A shared unit has a
  control word for each slot in use (`units[].control`): the operation, and for each port the number of its
  source in `units[].inputs`.
- **FIFOs** take a word in the slot in which their input is there, one each interval, and hold `depth` of
  them (`fifos`).
- **Ports and handshake** of the Verilog: `clk`, `rst` (synchronous; `--reset` names another: `rst_n`,
  `arst` or `arst_n`; it resets valid bits, slots and addresses of RAM alone), `ce`, `in_valid`, at an
  interval above 1 `in_ready`, low in reset, the inputs in the order of `problem.inputs`; `out_valid`,
  `out_ok`, and the outputs in the order of `problem.outputs`, `latency.cycles` after the inputs. Names that
  are words of Verilog have an underscore behind them.
- **Stage by stage**: `cordicc trace PLAN --operation o5 --inputs in.csv --sample 17` lists operands, results
  and every signal of the unit for one sample, in hexadecimal and as integers, under the names of the unit's
  module, with the cycle in which each has its word, counted from the operation's `start` and from the
  sample's entry. Sample k of a stream without gaps enters in cycle k · `initiation_interval`, counted from
  the first slot 0; cycles with `ce` low do not count. Words that stand for no number are listed too, as the
  Verilog has them.
"""


def plan_page() -> str:
    """Return the reference of the fields of a plan."""
    rows = [f"| `{field}` | {_with_code(about)} |\n" for field, about in _fields(schema(), "")]
    return _PLAN_HEAD + "".join(dict.fromkeys(rows)) + _HARDWARE


def _with_code(text: str) -> str:
    """Return a text as `_plain` does, but for what is between backticks."""
    return "`".join(part if at % 2 else _plain(part) for at, part in enumerate(text.split("`")))


def _fields(described: Mapping[str, Any], path: str) -> Iterator[tuple[str, str]]:
    """Yield the path of every field below a schema, and what the schema says of it."""
    if path and "description" in described:
        yield path.removeprefix("."), described["description"]
    for name, inner in described.get("properties", {}).items():
        yield from _fields(inner, f"{path}.{name}")
    for key, step in (("items", "[]"), ("additionalProperties", ".*")):
        if isinstance(described.get(key), dict):
            yield from _fields(described[key], path + step)
    for inner in described.get("oneOf", []):
        yield from _fields({key: value for key, value in inner.items() if key != "description"}, path)


def generated() -> dict[Path, str]:
    """Return the texts of everything that is generated, by path."""
    return {DOCS / "diagnostics.md": diagnostics_page(), DOCS / "plan.md": plan_page(), **gallery()}


def main() -> None:
    """Write what differs."""
    for path, text in generated().items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
            print(f"wrote {path.relative_to(ROOT)}", file=sys.stderr)


if __name__ == "__main__":
    main()
