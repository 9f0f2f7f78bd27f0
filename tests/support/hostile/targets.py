"""Hostile targets: the default one, and one of fixed point, with something in them replaced."""

from __future__ import annotations

import re
from importlib import resources

from tests.support.hostile.cases import Case, Content

PROBLEM = "inputs: {x: [0.5, 1], y: [0.1, 0.9]}\nequations: ['w = atan2(y, x)']\n"
KINEMATIC = resources.files("cordicc.targets").joinpath("kinematic.yaml").read_text(encoding="utf-8")
FIXED = resources.files("cordicc.targets").joinpath("fixed24.yaml").read_text(encoding="utf-8")


def changed(pattern: str, new: str, text: str = KINEMATIC) -> str:
    made, count = re.subn(pattern, new.replace("\\", r"\\"), text, count=1, flags=re.MULTILINE)
    assert count, pattern
    return made


BOMB = "x: &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"x{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 10)
)

CONTENTS: dict[str, tuple[Content, tuple[str, ...]]] = {
    "negative latency": (changed("latency: 44", "latency: -44"), ("E504",)),
    "a latency of 10^9": (changed("latency: 44", "latency: 1000000000"), ("E504",)),
    "a latency of 10^400": (changed("latency: 44", "latency: 1" + "0" * 400), ("E504",)),
    "a latency of 10^5000": (changed("latency: 44", "latency: 1" + "0" * 5000), ("E503", "E504")),
    "a latency of nan": (changed("latency: 44", "latency: .nan"), ("E504",)),
    "a latency of 44.0": (changed("latency: 44", "latency: 44.0"), ("E504",)),
    "a latency of true": (changed("latency: 44", "latency: true"), ("E504",)),
    "stages of 10^9": (changed("iterations: 30  #", "iterations: 1000000000  #"), ("E504",)),
    "a million stages": (
        changed("unpack: 2 ", "".join(f"s{i}: 1\n      " for i in range(15_000)) + "unpack: 2 "),
        ("E502", "E504"),
    ),
    "a million iterations": (
        changed("iterations: 30}", "iterations: 1000000}"), ("E505",),
    ),
    "a mantissa of a million bits": (changed("mantissa_bits: 32", "mantissa_bits: 1000000"), ("E505",)),
    "a negative mantissa": (changed("mantissa_bits: 32", "mantissa_bits: -1"), ("E505",)),
    "an unknown rule": (changed("rule: single-rotation", "rule: __import__"), ("E505",)),
    "words of a million bits": (changed("width: 24", "width: 1000000", FIXED), ("E505",)),
    "words of no bits": (changed("width: 24", "width: 0", FIXED), ("E505",)),
    "words of -24 bits": (changed("width: 24", "width: -24", FIXED), ("E505",)),
    "words of 10^400 bits": (changed("width: 24", "width: 1" + "0" * 400, FIXED), ("E505", "E503")),
    "a million guard bits": (changed("guard: auto", "guard: 1000000", FIXED), ("E505",)),
    "a clock of inf": (changed("clock_hz: 10000000", "clock_hz: .inf"), ("E504",)),
    "a clock of 0": (changed("clock_hz: 10000000", "clock_hz: 0"), ("E504",)),
    "an area of nan": (changed("area: 120.0", "area: .nan"), ("E504",)),
    "a name of 200 kB": (changed("name: kinematic", "name: " + "k" * 200_000), ("E504",)),
    "a description of 200 kB": (changed("Default. IMSCOR24", "D" * 200_000), ("E504",)),
    "a name with an escape": (changed("name: kinematic", 'name: "\\e[2J\\u202e"'), ("ok", "E504")),
    "aliases in the format": (changed("{kind: ieee-single}", "{kind: ieee-single, x: *a9}") + BOMB,
                              ("E503", "E504", "E505")),
    "an alias bomb": (BOMB + KINEMATIC, ("E504", "E503")),
    "an alias of itself": ("&a [*a]", ("E503",)),
    "a mapping of itself": ("&a {name: *a, units: *a, format: *a, clock_hz: *a}", ("E503", "E504")),
    "deep lists": ("[" * 100_000, ("E503",)),
    "deep mappings": ("{a: " * 50_000, ("E503",)),
    "50,000 unknown keys": ("".join(f"k{i}: 1\n" for i in range(20_000)), ("E504",)),
    "a tag that runs code": ("!!python/object/apply:os.system ['touch pwned']", ("E503",)),
    "a timestamp": (changed("name: kinematic", "name: 2001-12-14t21:59:43.10-05:00"), ("E504",)),
    "a binary": (changed("name: kinematic", "name: !!binary aGVsbG8="), ("E504", "E503")),
    "a set": (changed("functions: \\[mul\\]", "functions: !!set {mul: }"), ("E504", "E503")),
    "a key twice": (KINEMATIC + "name: again\n", ("E503",)),
    "two documents": (KINEMATIC + "---\n" + KINEMATIC, ("E503",)),
    "a list": ("[1, 2]", ("E503",)),
    "null": ("", ("E503",)),
    "Latin-1": (KINEMATIC.encode() + b"# \xe9", ("E502",)),
    "a control character": (KINEMATIC + "# \x07", ("E503", "E502")),
    "a megabyte": (KINEMATIC + "#" * (1 << 20), ("E502",)),
    "keys that are no text": ("{1: 2, [a]: 3, {b: c}: 4, null: 5, 2001-12-14: 6}", ("E503", "E504")),
}  # fmt: skip

CASES = [
    Case(f"target: {name}", ("compile", "p.yaml", "-o", "out", "-q", "--target", "t.yaml"),
         {"p.yaml": PROBLEM, "t.yaml": content}, codes)
    for name, (content, codes) in CONTENTS.items()
]  # fmt: skip
