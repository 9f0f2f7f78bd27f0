"""Hostile tables: samples of a problem, inputs of a simulation."""

from __future__ import annotations

from pathlib import Path

from tests.support.hostile.cases import Case, Content

PROBLEM = "inputs: {x: [0.5, 1]}\nequations: [w = 2*x]\n"

CONTENTS: dict[str, tuple[Content, tuple[str, ...]]] = {
    "nothing": ("", ("E612", "E220")),
    "a header alone": ("x\n", ("ok", "E220")),
    "a byte order mark": ("\ufeffx\n0.7\n", ()),
    "nan": ("x\n0.7\nnan\n", ("E614", "E220")),
    "inf": ("x\n-inf\n", ("E614", "E220")),
    "1e999": ("x\n1e999\n", ("E614", "E220")),
    "hexadecimal": ("x\n0x1p-1\n", ("E614", "E220")),
    "underscores": ("x\n0_7\n", ("E614", "E220")),
    "Arabic digits": ("x\n٠.٧\n", ("E614", "E220")),
    "words": ("x\nlarge\n", ("E614", "E220")),
    "a field too many": ("x\n0.7,1\n", ("E613", "E220")),
    "a column twice": ("x,x\n0.7,0.8\n", ("E612", "E220")),
    "semicolons": ("x;y\n0.7;1\n", ("E612", "E220")),
    "another column": ("y\n0.7\n", ("E612", "E220")),
    "an open quote": ('x\n"0.7\n' + "0.7\n" * 1000, ("E611", "E613", "E614", "E220")),
    "a quoted megabyte": ('x\n"' + "0\n" * 700_000 + '"\n', ("E600", "E611", "E614", "E220")),
    "a line of a megabyte": ("x\n" + "7" * (1 << 21) + "\n", ("E600", "E611", "E614", "E220")),
    "a header of a megabyte": ("x" * (1 << 21), ("E600", "E611", "E612", "E220")),
    "100,000 columns": (",".join(f"x{i}" for i in range(100_000)) + "\n", ("E600", "E612", "E220")),
    "NUL": ("x\n0.7\0\n", ("E611", "E614", "E220")),
    "Latin-1": (b"x\n0.7\xe9\n", ("E600", "E611", "E220")),
    "random bytes": (
        bytes((i * 7919 + i // 3) % 256 for i in range(100_000)),
        ("E600", "E611", "E612", "E220"),
    ),
    "a zip file": (b"PK\x03\x04" + bytes(1000), ("E600", "E611", "E612", "E220")),
    "200,000 rows": ("x\n" + "0.7\n" * 200_000, ("ok", "E220")),
    "a number of 100,000 digits": ("x\n0." + "7" * 100_000 + "\n", ()),
}


def rows(count: int) -> str:
    return "x\n" + "0.7\n" * count


def hundreds_of_megabytes(folder: Path) -> None:
    with (folder / "in.csv").open("w", encoding="ascii") as file:
        file.write("x\n")
        for _ in range(300):
            file.write("0.7\n" * 250_000)


INPUTS = [
    Case(f"inputs: {name}", ("simulate", "p.yaml", "--inputs", "in.csv", "--no-reference"),
         {"p.yaml": PROBLEM, "in.csv": content}, codes)
    for name, (content, codes) in CONTENTS.items()
]  # fmt: skip

SAMPLES = [
    Case(f"samples: {name}", ("check", "p.yaml"),
         {"p.yaml": PROBLEM + "samples: in.csv\n", "in.csv": content}, codes)
    for name, (content, codes) in CONTENTS.items()
]  # fmt: skip

ARCHIVES = [
    Case(f"inputs: {name}", ("simulate", "p.yaml", "--inputs", "in.npz"),
         {"p.yaml": PROBLEM, "in.npz": content}, ("E600", "E611", "E612", "E614"))
    for name, content in {
        "an archive of nothing": b"",
        "a torn archive": b"PK\x03\x04" + bytes(1000),
        "an empty archive": b"PK\x05\x06" + bytes(18),
        "a text as an archive": b"x\n0.7\n",
    }.items()
]  # fmt: skip

CASES = [
    *INPUTS,
    *SAMPLES,
    *ARCHIVES,
    Case("samples of 300 MB", ("check", "p.yaml"), {"p.yaml": PROBLEM + "samples: in.csv\n"}, ("E220",),
         hundreds_of_megabytes),
]  # fmt: skip
