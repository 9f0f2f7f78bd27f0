"""Where a bound holds: conditions on a sample, judged by the same enclosures as the bound, for one sample.

The margin of an operation is 0 where a derivative of its results is infinite or a choice is made: the norm
of a vector whose angle is taken, a divisor, a root, the second result of an implicit equation, the number
whose sign decides. A condition demands a margin, of the exact and of the computed operands. Or it demands
that the sample's own bound, from enclosures of this sample alone, is at most the bound that is stated.
"""

from __future__ import annotations

from collections.abc import Sequence

from cordicc.base.arrays import Bools
from cordicc.certify.error_network import ErrorNetwork, Step
from cordicc.certify.operator_models import CHOOSER
from cordicc.certify.sweep import Forward, errors
from cordicc.plan.stated_accuracy import Predicate

OWN_BOUND = "own bound"


_KINDS = {
    ("vector", 1): ("norm", "norm of ({0}, {1})"),
    ("vector", 0): ("divisor", "|{0}|"),
    ("vector", -1): ("norm", "sqrt(x^2 - y^2) of x = {0}, y = {1}"),
    ("implicit", 1): ("rest", "sqrt(A^2 + B^2 - C^2) of A = {0}, B = {1}, C = {2}"),
    ("implicit", -1): ("rest", "sqrt(A^2 - B^2 + C^2) of A = {0}, B = {1}, C = {2}"),
    ("lightcone", None): ("root", "sqrt(u v) of u = {0}, v = {1}"),
}


def margin(step: Step, threshold: float) -> Predicate:
    """Return the condition that an operation has a margin."""
    names = [o if isinstance(o, str) else f"{o.interval.lo:.6g}" for o in step.operands]
    if step.op in CHOOSER:
        kind, form = "sign", "|{0}|"
        names = [names[CHOOSER[step.op]]]
    else:
        kind, form = _KINDS[step.op, step.params.get("m")]
    text = f"{form.format(*names)} >= {threshold:.6g} (equation of '{step.equation}')"
    return Predicate(kind, threshold, text, step.id)


def own_bound(threshold: float) -> Predicate:
    """Return the condition on the sample's own bound."""
    return Predicate(OWN_BOUND, threshold, f"the sample's own bound <= {threshold:.6g}")


def singular(step: Step) -> bool:
    """Tell whether an operation needs a margin."""
    if step.op == "vector" and step.params["m"] >= 0:
        return step.results[1] is not None
    if step.op == "flip":
        return step.operands[0] != step.operands[1]
    return step.op in ("vector", "lightcone", "implicit", "sign", "select")


def meets(net: ErrorNetwork, output: str, conditions: Sequence[Predicate], made: Forward) -> Bools:
    """Tell which samples meet conditions, given their forward sweep over at least what is upstream."""
    kept = ~made.empty(net.upstream(output))
    for condition in conditions:
        if condition.kind == OWN_BOUND:
            kept &= errors(net, net.upstream(output), output, made) <= condition.threshold
        else:
            assert condition.operation is not None
            kept &= made.squares[condition.operation].lo >= condition.threshold * condition.threshold
    return kept
