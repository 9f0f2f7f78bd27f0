"""Hostile places: what a path that is read or written can be other than a plain file or folder."""

from __future__ import annotations

import os
from pathlib import Path

from tests.support.hostile.cases import Case, compiling
from tests.support.hostile.graphs import graph

SMALL = "inputs: {x: [0.5, 1]}\nequations: [w = 2*x]\n"


def at(path: str, *arguments: str) -> tuple[str, ...]:
    return tuple(path if argument == "@" else argument for argument in arguments)


def loop(folder: Path) -> None:
    (folder / "loop").symlink_to("loop")


def pipe(folder: Path) -> None:
    os.mkfifo(folder / "pipe")


def folder_in_the_way(folder: Path) -> None:
    (folder / "d").mkdir()


def plan_folder_in_the_way(folder: Path) -> None:
    (folder / "out" / "plan.json").mkdir(parents=True)


READERS = {
    "check": (("check", "@"), ("E100",)),
    "schedule": (("schedule", "@"), ("E600", "E801")),
    "plan": (("simulate", "@"), ("E600", "E602", "E100")),
    "target": (("compile", "p.yaml", "-o", "out", "-q", "--target", "@"), ("E501", "E502", "E503")),
    "inputs": (("simulate", "p.yaml", "--inputs", "@"), ("E600", "E612", "E611", "E613")),
    "expected": (("simulate", "p.yaml", "--compare", "in.csv", "@"), ("E600", "E612", "E611", "E613")),
}
"""What is read, and the codes with which a place that cannot be read is told."""

PLACES = {
    "nothing": ("none", None),
    "a folder": ("d", folder_in_the_way),
    "a loop of links": ("loop", loop),
    "a device without end": ("/dev/zero", None),
    "a device without content": ("/dev/null", None),
    "a path through a file": ("p.yaml/x", None),
    "a path of 10,000 characters": ("x" * 10_000, None),
}

READ = [
    Case(
        f"{place} as {what}",
        at(path, *arguments),
        {"p.yaml": SMALL, "in.csv": "x\n0.7\n"},
        (*codes, "E208"),
        prepare,
    )
    for what, (arguments, codes) in READERS.items()
    for place, (path, prepare) in PLACES.items()
]

PIPES = [
    Case(f"a pipe without a writer as {what}", at("pipe", *READERS[what][0]), {"p.yaml": SMALL},
         (*READERS[what][1], "E208"), pipe)
    for what in ("check", "schedule", "target")
]  # fmt: skip

WRITTEN = [
    Case(f"{place} as output folder", ("compile", "p.yaml", "-o", path, "-q"), {"p.yaml": SMALL},
         ("E600",), prepare)
    for place, (path, prepare) in {
        "a loop of links": ("loop", loop),
        "a file": ("p.yaml", None),
        "a path through a file": ("p.yaml/x", None),
        "a device": ("/dev/null", None),
        "a pipe": ("pipe", pipe),
        "a system folder": ("/proc/none", None),
        "a path of 10,000 characters": ("x" * 10_000, None),
    }.items()
]  # fmt: skip

FULL = [
    Case(f"{' '.join(arguments[:-1])} to a full disk", arguments, files, ("E600",))
    for arguments, files in [
        (("simulate", "p.yaml", "--outputs", "/dev/full"), {"p.yaml": SMALL}),
        (("simulate", "p.yaml", "--vcd", "/dev/full"), {"p.yaml": SMALL}),
        (
            ("schedule", "g.json", "-o", "/dev/full"),
            {"g.json": graph(1, [])},
        ),
    ]
]

CASES = [
    *READ,
    *PIPES,
    *WRITTEN,
    *FULL,
    Case("a folder where plan.json goes", ("compile", "p.yaml", "-o", "out", "-q"), {"p.yaml": SMALL},
         ("E600",), plan_folder_in_the_way),
    compiling("no samples", f"{SMALL}samples: none.csv\n", "E220"),
    compiling("samples from a device", f"{SMALL}samples: /dev/zero\n", "E220"),
]  # fmt: skip
