"""Rules that save multipliers: squares multiplied out, roots, orders of factors, pairs of sums."""

from fractions import Fraction
from pathlib import Path

import pytest

from cordicc.rewrite.rules import half_sums, product_pairs, squares
from cordicc.rewrite.search.costs import Costs
from tests.support.rewriting import certain, multipliers, problem_of, same_where, searched, units

ENDS = ((2, 3, -9, 8), (-2, 1, 7, -9), (1, 2, 9, 8), (3, -1, -8, -9))
LEGS = "ca = cos(a)\nsa = sin(a)\n" + "\n".join(
    f"u{i} = x + {p}*ca - {q}*sa + {b}\nv{i} = y + {p}*sa + {q}*ca + {c}\nf{i} = sqrt(u{i}**2 + v{i}**2 + 4)"
    for i, (p, q, b, c) in enumerate(ENDS)
)
LENGTHS = "f0, f1, f2, f3"
BOX = "x=-1:1, y=-1:1, a=-1:1"


def test_squares_over_shared_values(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, BOX, LEGS, LENGTHS)
    assert multipliers(certain(problem)) == 8
    assert multipliers(searched(problem).graph) == 4


def test_a_root_of_a_square_and_a_rest_takes_no_product_for_the_square(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=1:2, y=1:2", "r = sqrt(4*x**2 + 4*x + 3*y + 2)", "r")
    graph = searched(problem).graph
    assert units(graph) == ["implicit"]
    assert multipliers(graph) == 0


def test_a_root_keeps_who_is_valid(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-2:2, w=-4:4", "r = sqrt(x**2 + w)", "r")
    samples = {"x": [0.0, 0.0, 1.0, 2.0, 2.0], "w": [0.0, -1.0, -2.0, -3.0, 4.0]}
    same_where(problem, searched(problem).graph, samples)


def test_products_of_three_factors_share_one_of_two(tmp_path: Path) -> None:
    equations = "u = x*(y*w) + 1\nv = (x*k)*y + 2\nt = (y*x)*x"
    problem = problem_of(tmp_path, "x=1:2, y=1:2, w=1:2, k=1:2", equations, "u, v, t")
    assert multipliers(searched(problem).graph) == 4


@pytest.mark.parametrize(
    ("first", "second", "least"),
    [
        ("a*c - b*d", "b*c + a*d", 3),
        ("a*c + b*d", "b*c + a*d", 2),
        ("a*c - b*d", "b*c - a*d", 2),
        ("a*c - b*d", "a*d - b*c", 2),
        ("b*d - a*c", "a*d + b*c", 3),
        ("a*c + b*d", "a*b + c*d", 2),
    ],
)
def test_two_sums_of_two_products(tmp_path: Path, first: str, second: str, least: int) -> None:
    inputs = "a=1:2, b=-2:-1, c=1:3, d=2:3"
    problem = problem_of(tmp_path, inputs, f"p = {first}\nq = {second}", "p, q")
    graph = searched(problem).graph
    assert multipliers(graph) == least
    same_where(problem, graph, {"a": [1.0, 1.5], "b": [-2.0, -1.25], "c": [1.0, 2.5], "d": [3.0, 2.25]})


def test_a_sum_of_squares_as_the_square_of_its_root(tmp_path: Path) -> None:
    equations = "t = atan2(y, x)\nr = hypot(x, y)\nk = w*(x**2 + y**2)"
    problem = problem_of(tmp_path, "x=1:2, y=1:2, w=1:2", equations, "t, r, k")
    assert multipliers(searched(problem).graph) == 2


def test_the_sign_of_the_partner(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, "a=1:2, b=-2:-1, c=1:3, d=2:3", "p = a*c - b*d\nq = b*c + a*d", "p, q")
    searched(problem)
    cheaper = product_pairs.cheaper
    monkeypatch.setattr(product_pairs, "cheaper", lambda store, x, y, m: cheaper(store, x, y, -m))
    with pytest.raises(AssertionError):
        searched(problem)


@pytest.mark.exhaustive(reason="searches for legs twice, once to see a wrong identity found")
def test_the_part_without_inputs_is_a_number_only_if_the_field_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = problem_of(tmp_path, BOX, LEGS, LENGTHS)
    searched(problem)
    monkeypatch.setattr(
        squares.Squares,
        "reduced",
        lambda self, terms: {m: f for m, f in terms.items() if len(m) < 2 or m[0] != m[1]},
    )
    with pytest.raises(AssertionError):
        searched(problem)


def test_preferred_implicit_units_come_before_every_goal(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=1:2, y=1:2", "r = sqrt(x**2 + y + 1)", "r")
    graph = certain(problem, "latency")
    krieger = search_with(problem, graph, preferred=False)
    assert units(krieger) == ["lightcone"]
    assert units(search_with(problem, graph, preferred=True)) == ["implicit"]


def search_with(problem, graph, *, preferred: bool):
    from cordicc.ir.problem import input_intervals
    from cordicc.rewrite.cheapest import cheapest
    from cordicc.rewrite.passes.base import PassContext
    from cordicc.targets.target_file import load_target

    costs = Costs.of(load_target("krieger96"), implicit=True, preferred=preferred)
    return cheapest(problem, graph, PassContext(input_intervals(problem), "latency"), costs).graph


def test_half_sums_of_products_of_three_angles(tmp_path: Path) -> None:
    equations = """
p = cos(a)*cos(b)*cos(c) + sin(a)*sin(b)*sin(c)
q = sin(a)*cos(b)*cos(c) - cos(a)*sin(b)*sin(c)
r = cos(a)*sin(b)*cos(c) + sin(a)*cos(b)*sin(c)
s = cos(a)*cos(b)*sin(c) - sin(a)*sin(b)*cos(c)
"""
    problem = problem_of(tmp_path, "a=-3:3, b=-2:2, c=-3:3", equations, "p, q, r, s")
    graph = searched(problem).graph
    assert units(graph) == ["rotate"] * 3
    assert multipliers(graph) == 0


def test_a_chain_of_rotations(tmp_path: Path) -> None:
    equations = "p = x*cos(a)\nq = x*sin(a)"
    problem = problem_of(tmp_path, "a=-3:3, x=1:2", equations, "p, q")
    graph = searched(problem).graph
    assert units(graph) == ["rotate"]
    assert multipliers(graph) == 0


def test_what_halves_rests_on_its_factors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    equations = "p = cos(a)*cos(b) + 2*sin(a)*sin(b)\nq = cos(a)*sin(b) + 2*sin(a)*cos(b)"
    problem = problem_of(tmp_path, "a=-1:1, b=-1:1", equations, "p, q")
    searched(problem)
    monkeypatch.setattr(half_sums, "HALF", Fraction(1, 3))
    with pytest.raises(AssertionError):
        searched(problem)
