"""The list of rules: each is named, says its mathematics, fires, and is applied by the list alone."""

import ast
import importlib
import pkgutil
from pathlib import Path

import pytest

from cordicc.ir.graph import Value
from cordicc.ir.problem import input_intervals
from cordicc.rewrite import rules
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.catalogue import RULES
from cordicc.rewrite.rules.rule import Given, Need, Rule
from cordicc.rewrite.search.start import fill, sample_points
from tests.support.paths import PACKAGE
from tests.support.rewriting import certain, problem_of

FIRES: dict[str, tuple[str, str, str]] = {
    "equal hyperbolic angles": ("x=-3:3", "u = 3*asinh(sinh(x/3))\nv = cosh(x/3)", "u, v"),
    "sums of products": ("x=-2:2, y=-2:2, t=-3:3", "p = x*cos(t) - y*sin(t) + 1", "p"),
    "circle equations": ("x=-2:2, y=-2:2, w=-1:1", "t = atan2(y, x) - acos(w/hypot(x, y))", "t"),
    "frames": (
        "x=-2:2, y=-2:2, w=-3:3",
        "q = atan2(y, x)\nt = atan2(y*cos(w) + x*sin(w), x*cos(w) - y*sin(w))",
        "q, t",
    ),
    "principal values": ("x=-1:1, w=2:3", "e = asin(x/w)\nz = acos(x/w)", "e, z"),
    "roots of squares": ("x=0.5:1.8, y=-1:1", "a = sqrt(x**2 + 2*x*y + y**2)", "a"),
    "completed squares": ("x=-1:1, y=-1:1, t=-3:3", "a = sqrt(x**2 + y**2 - 2*x*y*cos(t))", "a"),
    "chains of lengths": ("x=-1:1, y=-1:1, w=-1:1", "r = hypot(x, y)\na = sqrt(x**2 + y**2 + w**2)", "r, a"),
    "orders of factors and quotients": ("x=1:2, y=1:2, w=1:2, k=1:2", "u = k*x/w\nv = k*y/w", "u, v"),
    "unit vectors": ("x=0.2:2, y=0.2:2", "n = hypot(x, y)\nu = x/n\nv = y/n", "n, u, v"),
    "quotients by norms": (
        "x=-2:2, y=-2:2, a=-1:1, b=-1:1",
        "u = (a*x + b*y)/hypot(x, y)\nv = (b*x - a*y)/hypot(x, y)",
        "u, v",
    ),
    "turned vectors": ("x=-2:2, y=-2:2, t=-3:3", "u = hypot(x, y)*sin(atan2(y, x) - t)", "u"),
    "constant offsets": ("t=-3:3", "a = sin(t - 0.4)\nb = sin(t)", "a, b"),
    "sums of the angles of vectors": (
        "x=-2:2, y=-2:2, u=-2:2, v=-2:2",
        "t = atan2(y, x) + atan2(v, u)",
        "t",
    ),
    "roots of two equations": (
        "x=0.1:0.6, y=0:0.3",
        "D = (x**2 + y**2 - 0.18)/0.18\nq2 = acos(D)\n"
        "q1 = atan2(y, x) - atan2(0.3*sin(q2), 0.3 + 0.3*cos(q2))",
        "q1, q2",
    ),
    "common denominators": (
        "x=-2:2, y=-2:2, v=-1:1, w=-1:1",
        "q = atan2(y, x)\nt = atan2(v*cos(q) - w*sin(q), w*cos(q) + v*sin(q) + 1)",
        "q, t",
    ),
    "roots of products": ("x=1:2, y=1:2", "a = sqrt(x + 1)*sqrt(y + 1)", "a"),
    "sums of angles": (
        "x=-2:2, y=-2:2, w=-3:3",
        "q = atan2(y, x)\nt = atan2(cos(q)*cos(w) + sin(q)*sin(w), sin(q)*cos(w) - cos(q)*sin(w))",
        "q, t",
    ),
    "squares of norms": ("x=1:2, y=1:2, w=1:2", "r = hypot(x, y)\nk = w*(x**2 + y**2)", "r, k"),
    "squares of norms in longer sums": (
        "x=-1:1, y=-1:1, w=-1:1",
        "r = atan2(y, x)\nk = x**2 + w**2 + y**2",
        "r, k",
    ),
    "squares multiplied out": (
        "x=-2:2, y=-2:2",
        "f = sqrt((x + 1)**2 + (y - 1)**2 + 9)\ng = sqrt((x - 3)**2 + (y + 1)**2 + 9)",
        "f, g",
    ),
    "mirrored angles": ("x=-1:1, y=-1:1, z=-1:1", "p = atan2(y, x*z)\nq = atan2(-y, -x*z)", "p, q"),
    "half sums and half differences": (
        "a=-1:1, b=-1:1",
        "p = cos(a)*cos(b) + 2*sin(a)*sin(b)\nq = cos(a)*sin(b) + 2*sin(a)*cos(b)",
        "p, q",
    ),
    "chains of rotations": (
        "a=-3:3, b=-3:3",
        "p = cos(a)*cos(b)\nq = sin(a)*cos(b)\nr = sin(b)*cos(a)",
        "p, q, r",
    ),
    "multiples of values": (
        "x=1:2, y=1:2",
        "u = (x + y)**2\nv = 3*x**2 + 6*x*y + 3*y**2 + 5",
        "u, v",
    ),
    "orders of factors": ("x=1:2, y=1:2, w=1:2, k=1:2", "u = x*(y*w)\nv = (x*k)*y", "u, v"),
    "pairs of sums of products": ("a=1:2, b=-2:-1, c=1:3, d=2:3", "p = a*c - b*d\nq = b*c + a*d", "p, q"),
}
"""A small problem by the name of the rule that finds something in it: inputs, equations, outputs."""


class Watched:
    """What rules are given, and what of it they have looked at."""

    def __init__(self, given: Given) -> None:
        self.given, self.seen = given, set[Need]()

    def __getattr__(self, name: str) -> object:
        needs = {"graphs": Need.GRAPHS, "moved": Need.GRAPHS, "outputs": Need.OUTPUTS}
        self.seen |= {needs[name]} if name in needs else set()
        return getattr(self.given, name)


def footprint(store: Store) -> tuple[int, int, int]:
    """Return how many operations, classes of equal values and sums of angles there are."""
    nodes = store.algebra.nodes
    made = [i for i, node in enumerate(nodes) if node.op != "const"]
    values = [Value(i, result) for i in made for result in range(len(nodes[i].definition.results))]
    return len(made), len({store.find(value) for value in values}), len(store.turns)


def given_for(folder: Path, inputs: str, equations: str, outputs: str) -> Given:
    problem = problem_of(folder, inputs, equations, outputs)
    graphs = [certain(problem, goal) for goal in ("processors", "latency")]
    points = sample_points(problem, graphs)
    assert points is not None
    filled = fill(problem, input_intervals(problem), graphs, points)
    assert filled is not None
    return Given(filled.store, graphs, filled.moved, filled.outputs, lifting=True, together=True)


def test_every_rule_is_named_once_and_says_its_mathematics() -> None:
    names = [rule.name for rule in RULES]
    assert sorted(names) == sorted(set(names)) == sorted(FIRES)
    assert all(rule.mathematics and "\n" not in rule.mathematics for rule in RULES)
    assert [r.name for r in RULES if not (r.words or r.formulas)] == ["equal hyperbolic angles"], (
        "this one makes values equal and adds none"
    )


@pytest.mark.parametrize("wanted", RULES, ids=lambda rule: rule.name)
def test_every_rule_fires_on_a_small_problem_and_explains_what_it_adds(wanted: Rule, tmp_path: Path) -> None:
    given = given_for(tmp_path, *FIRES[wanted.name])
    store = given.store
    for rule in RULES[: RULES.index(wanted)]:
        rule.run(given)
    before, first = footprint(store), len(store.algebra.nodes)
    watched = Watched(given)
    wanted.run(watched)
    assert footprint(store) != before
    assert watched.seen == wanted.needs - {Need.LIFTING, Need.TOGETHER}
    steps = {store.why[index][0] for index in range(first, len(store.algebra.nodes))}
    if wanted.formulas is None:
        assert steps <= {wanted.words, *wanted.cases.values()}
    else:
        assert all("`" in step for step in steps)


def test_a_rule_is_passed_over_where_it_lacks_something(tmp_path: Path) -> None:
    full = given_for(tmp_path, *FIRES["circle equations"])
    bare = Given(full.store)
    before = footprint(full.store)
    for rule in RULES:
        if rule.needs:
            rule.run(bare)
    assert footprint(full.store) == before


def test_the_list_alone_applies_rules() -> None:
    found: dict[str, Rule] = {}
    for module in pkgutil.iter_modules(rules.__path__):
        if module.name != "catalogue":
            members = vars(importlib.import_module(f"{rules.__name__}.{module.name}"))
            found |= {name: value for name, value in members.items() if isinstance(value, Rule)}
    assert sorted(rule.name for rule in found.values()) == sorted(rule.name for rule in RULES)
    takers: dict[str, set[str]] = {"RULES": set(), "a rule": set()}
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if rules.__name__ in text else ():
            if isinstance(node, ast.ImportFrom):
                names = {alias.name for alias in node.names}
                takers["RULES"] |= {path.stem} if "RULES" in names else set()
                takers["a rule"] |= {path.stem} if names & set(found) else set()
    assert takers == {"RULES": {"realisations"}, "a rule": {"catalogue"}}
