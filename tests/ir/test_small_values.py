"""Values near 0: as high precision has them, whatever double precision makes of them."""

import numpy as np
import pytest

from cordicc.base.diagnostics import Source
from cordicc.frontend.load import parse_problem
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.meaning.small_values import small_values

X = np.linspace(0.1, 0.9, 300)


def graph(expression: str):
    text = f"inputs: {{x: [0, 1], q: [0, 2]}}\nequations: ['e = {expression}', 'f = x*q']\noutputs: [e, f]\n"
    return parse_problem(Source("p.yaml", text)).problem.graph


@pytest.mark.parametrize(
    "expression",
    [
        "cos(q) - x",  # well above its rounding
        "sin(q)**2 + cos(q)**2 - 1",  # nothing but rounding
        "(1e8 + cos(q)) - (1e8 + x)",  # cancels
        "exp(60*q)*(cos(q) - x)",
    ],
)
@pytest.mark.parametrize("noise", [1e-7, 0.0])
def test_they_are_those_of_high_precision(expression: str, noise: float) -> None:
    made = graph(expression)
    inputs = {"x": X, "q": np.arccos(X) + noise * np.sin(1e3 * X)}
    exact = reference_outputs(made, inputs)[0]["e"]
    seen = small_values(made, inputs)["e"]
    assert np.max(np.abs(seen - exact)) <= 1e-6 * np.max(np.abs(exact))


def test_a_value_is_missing_where_high_precision_has_none():
    made = graph("sqrt(cos(q) - x) + 1/(x - 1/2)")
    q = np.arccos(np.clip(X, 0, 1)) - np.where(np.arange(X.size) % 3 == 0, -1e-9, 1e-9)
    inputs = {"x": np.where(np.arange(X.size) == 100, 0.5, X), "q": q}
    exact, seen = reference_outputs(made, inputs)[0]["e"], small_values(made, inputs)["e"]
    assert np.array_equal(np.isnan(seen), np.isnan(exact))
    assert 0 < np.isnan(seen).sum() < X.size


def test_without_samples_there_are_no_values():
    assert small_values(graph("cos(q) - x"), {"x": np.empty(0), "q": np.empty(0)})["e"].size == 0
