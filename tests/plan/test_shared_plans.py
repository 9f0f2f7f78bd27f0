"""The plans that tests share are those that the compiler makes."""

import cordicc
from cordicc.plan.verify import verify
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled, planned

PROBLEM = EXAMPLES / "wheel_beta.yaml"


def test_a_shared_plan_has_the_bytes_of_a_compiled_one() -> None:
    assert (
        compiled(PROBLEM, target="imscor24").to_json()
        == cordicc.compile(PROBLEM, target="imscor24").to_json()
    )


def test_a_plan_is_made_once() -> None:
    assert compiled(PROBLEM) is compiled(PROBLEM, target="kinematic", ii=1)


def test_a_plan_placed_anew_keeps_its_operations() -> None:
    path = EXAMPLES / "wheel_suspension.yaml"
    first, again = planned(path), planned(path, ii=3)
    verify(again)
    assert again.initiation_interval == again.options.ii == 3
    assert len(again.units) < len(first.units)
    meant = [[(o.id, o.op, o.params, o.operands) for o in plan.operations] for plan in (first, again)]
    assert meant[0] == meant[1]
