"""Strategies and properties of the fuzzer: problem texts, whole compilations, plans read back.

A property takes what its strategy makes and returns how it ended; it raises for everything that must not
happen.  Diagnostics are the only way to fail, and each has to have a known code and a text to show.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from cordicc import pipeline
from cordicc.artefacts import artefacts
from cordicc.base.codes import CODES
from cordicc.base.diagnostics import InvalidInput, Unattainable
from cordicc.emulate import cycle, functional
from cordicc.expressions.syntax import FUNCTIONS
from cordicc.ir import sampling
from cordicc.plan.file import dump, parse
from cordicc.readback import check_plan

Text = str

INPUTS = ("x", "y", "S")
RANGES = ("[0.5, 1]", "[-1, 1]", "[0, 0]", "[-3, 10]", "{range: [0.1, pi/2], unit: rad}")
WILD_RANGES = (
    *RANGES,
    "[1, 0]",
    "[-1e300, 1e300]",
    "[1e-300, 2e-300]",
    "{range: [0, 1], unit: deg}",
    "[0]",
    "",
)
NUMBERS = ("2", "0.5", "1", "0", "3", "0.1", "pi", "deg", "a")
WILD_NUMBERS = (
    *NUMBERS,
    "1e300",
    "1e-300",
    "1e-400",
    "9999999999999999999",
    ".5",
    "1_0",
    "0x10",
    "inf",
    "nan",
)
POWERS = ("2", "3", "0.5", "-1", "1.5", "-2")
WILD_POWERS = (*POWERS, "64", "1e9", "x", "1/3", "2**2", "-2**2**2")
ODD = (
    *(
        "(",
        ")",
        "[",
        "]",
        "{",
        "}",
        ":",
        "#",
        "&a ",
        "*a",
        "!!python/name:os.system ",
        "|",
        ">",
        "'",
        '"',
        "\\",
    ),
    *(
        "\0",
        "\t",
        "\r",
        "\u2028",
        "\ufeff",
        "é",
        "π",
        "²",
        "𝑥",
        "\u202e",
        "\x1b[2J",
        "\ud800",
        "-",
        "=",
        "**",
    ),
    *(
        ",",
        "%",
        "\n",
        "\n  ",
        "\n- ",
        "? ",
        "@",
        "`",
        "~",
        "<<: ",
        "---\n",
        "...\n",
        "1e999",
        "None",
        "valid",
    ),
)
SCALARS: tuple[Any, ...] = (
    *(
        None,
        True,
        False,
        0,
        -1,
        1,
        2,
        10**6,
        10**30,
        0.5,
        -0.0,
        1e308,
        5e-324,
        "",
        "x",
        "o1",
        "1/0",
        "nan",
        "0x1p3",
    ),
    *("1e400", "\x1b[2J", "\ud800", [], {}, [[]], [0], {"value": "x"}, {"constant": "1"}),
)


class Grammar(NamedTuple):
    """What texts are made of; a wild one has what no problem may have."""

    numbers: Sequence[str]
    powers: Sequence[str]
    ranges: Sequence[str]
    leaves: int
    equations: int


TAME = Grammar(NUMBERS, POWERS, RANGES, 6, 3)
WILD = Grammar(WILD_NUMBERS, WILD_POWERS, WILD_RANGES, 12, 5)


def expressions(grammar: Grammar, names: Sequence[str]) -> SearchStrategy[Text]:
    """Return texts of expressions in some names."""
    leaves = st.one_of(st.sampled_from(names), st.sampled_from(names), st.sampled_from(grammar.numbers))

    def grown(inner: SearchStrategy[Text]) -> SearchStrategy[Text]:
        calls = st.sampled_from(sorted(FUNCTIONS)).flatmap(
            lambda name: st.lists(inner, min_size=FUNCTIONS[name][0], max_size=FUNCTIONS[name][1] or 3).map(
                lambda operands: f"{name}({', '.join(operands)})"
            )
        )
        pairs = st.tuples(inner, st.sampled_from(["+", "-", "*", "/"]), inner)
        return st.one_of(
            pairs.map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
            st.tuples(inner, st.sampled_from(grammar.powers)).map(lambda p: f"({p[0]})**{p[1]}"),
            inner.map(lambda a: f"-{a}"),
            calls,
        )

    return st.recursive(leaves, grown, max_leaves=grammar.leaves)


@st.composite
def equations(draw: DrawFn, grammar: Grammar, target: str, names: Sequence[str]) -> Text:
    """Draw the text of an equation that defines a name."""
    inner = expressions(grammar._replace(leaves=3), names)
    kind = draw(st.sampled_from(["plain", "plain", "plain", "circular", "hyperbolic", "pair"]))
    if kind == "plain":
        return f"  - {target} = {draw(expressions(grammar, names))}\n"
    c, s = ("cosh", "sinh") if kind == "hyperbolic" else ("cos", "sin")
    lines = [
        f"{draw(inner)}*{c}({target}) + {draw(inner)}*{s}({target}) = {draw(inner)}"
        for _ in range(2 if kind == "pair" else 1)
    ]
    if kind == "pair":
        return f"  - solve: [{', '.join(lines)}]\n    for: {target}\n"
    branch = draw(st.sampled_from(["+", "-", "+", "-", ""]))
    return f"  - solve: {lines[0]}\n    for: {target}\n" + (f'    branch: "{branch}"\n' if branch else "")


@st.composite
def problems(draw: DrawFn, grammar: Grammar) -> Text:
    """Draw the text of a problem file."""
    count = draw(st.integers(1, len(INPUTS)))
    names = [*INPUTS[:count]]
    text = "constants: {a: 0.3}\n" if draw(st.booleans()) or grammar is TAME else ""
    text += "inputs:\n" + "".join(f"  {n}: {draw(st.sampled_from(grammar.ranges))}\n" for n in names)
    text += "equations:\n"
    targets = [f"w{i}" for i in range(draw(st.integers(1, grammar.equations)))]
    for target in targets:
        text += draw(equations(grammar, target, tuple(names)))
        names.append(target)
    if draw(st.booleans()):
        chosen = draw(st.lists(st.sampled_from(targets), min_size=1, unique=True))
        options = st.sampled_from(["{}", "{wrap: false}", "{max_error: 1e-3}"] if grammar is WILD else ["{}"])
        text += "outputs: {" + ", ".join(f"{name}: {draw(options)}" for name in chosen) + "}\n"
    if grammar is WILD and draw(st.booleans()):
        text += f"assume: ['{draw(expressions(grammar, INPUTS[:1]))} > 0']\n"
    return text


@st.composite
def mutated(draw: DrawFn, texts: SearchStrategy[Text]) -> Text:
    """Draw a text and delete, double, swap and insert pieces of it."""
    text = draw(texts)
    for _ in range(draw(st.integers(0, 4))):
        ends = sorted(draw(st.lists(st.integers(0, len(text)), min_size=4, max_size=4)))
        a, b, c, d = ends[0], min(ends[1], ends[0] + 12), *ends[2:]
        c, d = max(b, c), max(b, c, min(d, c + 12))
        change = draw(st.sampled_from(["delete", "double", "swap", "insert", "insert"]))
        if change == "delete":
            text = text[:a] + text[b:]
        elif change == "double":
            text = text[:b] + text[a:b] + text[b:]
        elif change == "swap":
            text = text[:a] + text[c:d] + text[b:c] + text[a:b] + text[d:]
        else:
            text = text[:a] + draw(st.sampled_from(ODD)) + text[a:]
    return text


PLAN_PROBLEMS = {
    "inputs: {x: [0.25, 0.5], a: [-1, 1]}\nequations: ['z = x*cos(a) + 0.1', 'b = x*a']\n": "kinematic",
    "inputs: {x: [0.5, 0.9]}\nequations: ['t = acos(x)', 'u = sqrt(x) - t']\n": "fixed24",
}


@cache
def plan_texts() -> tuple[Text, ...]:
    """Return plans that are changed."""
    made = []
    for text, target in PLAN_PROBLEMS.items():
        with tempfile.TemporaryDirectory() as name:
            path = Path(name) / "p.yaml"
            path.write_text(text, encoding="utf-8")
            made.append(dump(pipeline.compile_file(path, pipeline.Options(target)).plan))
    return tuple(made)


Place = tuple[Any, Any]
"""An object or a list, and a key or an index of it."""


def places(data: Any) -> list[Place]:
    """Return where the values of a plan stand, in a fixed order; long columns of samples by their start."""
    found: list[Place] = []
    todo = [data]
    while todo:
        item = todo.pop()
        pairs = item.items() if isinstance(item, dict) else enumerate(item[:50])
        for key, value in pairs:
            found.append((item, key))
            if isinstance(value, dict | list):
                todo.append(value)
    return found


@st.composite
def changed_plans(draw: DrawFn) -> Text:
    """Draw the text of a plan in which something is gone, doubled, swapped or replaced."""
    text = draw(st.sampled_from(plan_texts()))
    if draw(st.integers(0, 9)) == 0:
        return draw(mutated(st.just(text)))
    data = json.loads(text)
    for _ in range(draw(st.integers(1, 3))):
        all_places = places(data)
        item, key = all_places[draw(st.integers(0, len(all_places) - 1))]
        change = draw(st.sampled_from(["delete", "double", "swap", "replace", "replace", "near", "near"]))
        if change == "delete":
            del item[key]
        elif change == "double" and isinstance(item, list):
            item.insert(key, item[key])
        elif change == "swap":
            other, place = all_places[draw(st.integers(0, len(all_places) - 1))]
            item[key], other[place] = json.loads(json.dumps([other[place], item[key]]))
        elif change == "near" and type(item[key]) in (int, float):
            item[key] += draw(st.sampled_from([-1, 1, 2, 0.5]))
        elif change == "near" and isinstance(item[key], str):
            item[key] = draw(mutated(st.just(item[key])))
        else:
            item[key] = draw(st.sampled_from(SCALARS))
    return json.dumps(data)


def told(error: InvalidInput | Unattainable) -> str:
    """Return the codes of an error, after looking at each of its diagnostics."""
    assert error.diagnostics
    for each in error.diagnostics:
        assert each.code in CODES, each.code
        assert each.render().strip()
    codes = [each.code for each in error.diagnostics if each.code.startswith("E")]
    assert codes
    return ",".join(dict.fromkeys(codes))


def in_file(text: Text, use: Callable[[Path], str]) -> str:
    """Use a file that holds a text, half surrogate pairs included; return how that ended."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "p.yaml"
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            return use(path)
        except (InvalidInput, Unattainable) as error:
            return told(error)


def read(text: Text) -> str:
    """A text is a problem, or a diagnostic tells why not."""

    def use(path: Path) -> str:
        loaded = pipeline.read_problem(path)
        assert loaded.problem.graph.outputs
        return "ok"

    return in_file(text, use)


def compiled(text: Text) -> str:
    """A problem becomes a sound plan and whole files, or a diagnostic tells why not."""

    def use(path: Path) -> str:
        plan = pipeline.compile_file(path, pipeline.Options()).plan
        files = artefacts(plan)
        again = parse(files["plan.json"], "plan.json")
        check_plan(again)
        assert dump(again) == files["plan.json"]
        return "ok"

    return in_file(text, use)


def loaded(text: Text) -> str:
    """The text of a plan is refused, or the plan can be run both ways, drawn and written again."""
    try:
        plan = check_plan(parse(text, "plan.json"))
    except InvalidInput as error:
        return told(error)
    inputs = sampling.draw(plan.problem.workspace, 3, 0)
    machine = plan.arithmetic
    first, second = functional.run(plan, machine, inputs), cycle.run(plan, machine, inputs)
    for name in plan.outputs:
        assert first[name].tobytes() == second[name].tobytes(), name
    artefacts(plan)
    return "ok"


class Target(NamedTuple):
    """A part of the program with the strategy of its input."""

    strategy: SearchStrategy[Text]
    run: Callable[[Text], str]


TARGETS = {
    "problem text": Target(mutated(problems(WILD)), read),
    "compile": Target(problems(TAME), compiled),
    "plan reader": Target(changed_plans(), loaded),
}
