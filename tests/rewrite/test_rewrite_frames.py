"""The rule of frames holds for every order and sign of the components; broken, it does not."""

from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules import frames
from cordicc.rewrite.rules.norms import NORM_CHAINS
from cordicc.rewrite.rules.rule import Given
from cordicc.rewrite.search import realisations
from tests.support.rewriting import multipliers, problem_of, same_where, searched, units
from tests.support.stores import store_of_inputs

FORMS = [
    (op, parameter, order, p, q)
    for (op, parameter) in (("vector", 1), ("vector", -1), ("implicit", "+"), ("implicit", "-"))
    for order, p, q in product(((0, 1), (1, 0)), (1, -1), (1, -1))
]


def frame_of(form: tuple[str, object, tuple[int, int], int, int]) -> tuple[Store, Value]:
    """Return a store with one turned vector, and the angle of the unit that takes it."""
    op, parameter, (first, second), p, q = form
    store, given = store_of_inputs()
    turned = store.make("rotate", (given["x"], given["y"], given["t"]), (1,))
    legs = [store.scale(Fraction(2 * k), turned[i]) for k, i in ((p, first), (q, second))]
    if op == "vector":
        return store, store.make("vector", (*legs, given["z"]), (1, parameter))[1]
    return store, store.make("implicit", (legs[1], legs[0], given["c"]), (1, parameter))[0]


def differences(store: Store) -> list[float]:
    """Return, for each recorded sum of angles, how far it is from its angle modulo 2 pi."""
    turns = [np.exp(1j * store.numbers(a)) - np.exp(1j * store.numbers(b)) for a, b in store.turns]
    return [float(np.max(np.abs(turn))) for turn in turns]


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_sum_of_angles_and_second_result(form: tuple[str, object, tuple[int, int], int, int]) -> None:
    store, angle = frame_of(form)
    frames.FRAMES.run(Given(store))
    assert store.turns
    assert max(differences(store)) < 1e-12
    other = store.domains[angle][0]
    pairs = [(Value(angle.node, i), Value(other.node, i)) for i in range(2)]
    result = 0 if form[0] == "vector" else 1
    assert store.find(pairs[result][0]) == store.find(pairs[result][1])
    np.testing.assert_allclose(store.numbers(pairs[result][0]), store.numbers(pairs[result][1]), rtol=1e-12)


@pytest.mark.parametrize("form", FORMS[16:], ids=str)
def test_a_mirror_image_takes_the_other_branch(
    monkeypatch: pytest.MonkeyPatch, form: tuple[str, object, tuple[int, int], int, int]
) -> None:
    monkeypatch.setattr(frames, "OTHER_BRANCH", {"+": "+", "-": "-"})
    store, _ = frame_of(form)
    frames.FRAMES.run(Given(store))
    mirrored = (form[3] * form[4] > 0) == (form[2] == (1, 0))
    assert (max(differences(store)) > 1e-3) == mirrored


def test_legs_of_other_lengths_are_left_alone() -> None:
    store, given = store_of_inputs()
    a, b = store.make("rotate", (given["x"], given["y"], given["t"]), (1,))
    store.make("vector", (a, store.scale(Fraction(2), b), given["z"]), (1, 1))
    frames.FRAMES.run(Given(store))
    assert not store.turns


LEG = """
r = atan2(y, x)
g = w*cos(r) - v*sin(r)
k = u*sin(v + r) + g*cos(v + r)
l = u*cos(v + r) - g*sin(v + r)
t = atan2(-k, l)
"""


def test_validity_where_the_turned_vector_is_zero(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1, u=-1:1, v=-1:1, w=-1:1", LEG, "r, t")
    zeros = {
        "x": [1.0, 1.0, 0.0], "y": [0.0, 0.0, 0.0], "u": [0.0, 0.0, 0.5],
        "v": [0.5, 0.0, 0.5], "w": [0.0, 0.5, 0.5],
    }  # fmt: skip
    choice = searched(problem)
    assert units(choice.graph) == ["vector", "vector"]
    same_where(problem, choice.graph, zeros)
    monkeypatch.setattr(realisations, "requirements", lambda *given: [])
    monkeypatch.setattr(Store, "same_domain", lambda store, angle, other: None)
    same_where(problem, searched(problem).graph, {name: column[1:2] for name, column in zeros.items()})


CHAIN = "r = atan2(y, x)\nt = acos((4*x**2 + 4*w**2 + 4*y**2 - 1)/16)"


def test_squares_through_a_norm(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1, w=-1:1", CHAIN, "r, t")
    assert multipliers(searched(problem).graph) == 2


def test_a_norm_of_unequal_legs_is_no_sum_of_squares() -> None:
    store, given = store_of_inputs()
    squares = [store.mul(given[name], given[name]) for name in ("x", "y", "c")]
    total = store.add(store.add(squares[0], squares[1]), squares[2])
    store.make("vector", (store.scale(Fraction(2), given["x"]), given["y"], store.const(0)), (1, 1))
    before = len(store.algebra.nodes)
    NORM_CHAINS.run(Given(store))
    assert len(store.algebra.nodes) == before
    norm = store.make("vector", (given["y"], store.scale(Fraction(-1), given["x"]), store.const(0)), (1, 1))[
        0
    ]
    NORM_CHAINS.run(Given(store))
    made = [i for i in range(before, len(store.algebra.nodes)) if store.find(Value(i)) == store.find(total)]
    assert made
    assert norm in [
        v for i in range(before, len(store.algebra.nodes)) for v in store.algebra.nodes[i].operands
    ]
    for index in made:
        np.testing.assert_allclose(store.numbers(Value(index)), store.numbers(total), rtol=1e-12)
