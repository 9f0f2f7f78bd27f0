"""The search for shift sequences, and the command that lists, checks and searches them."""

from fractions import Fraction
from itertools import combinations_with_replacement, product
from math import atan, pi, prod

import pytest
from click.testing import Result

from cordicc.arith.kernels import shift_sequences
from cordicc.ir.meaning.exact import PI
from cordicc.studies.sequence_search import Conditions, Outcome, ZeroShift, merge, outcomes, run, tasks
from tests.support import command_line

ERROR = Fraction(1, 2**22)


def invoke(*arguments: object) -> Result:
    return command_line.run("sequences", *arguments)


def searched(conditions: Conditions, limit: int = 1, jobs: int = 1) -> Outcome:
    return merge(outcomes(tasks(conditions, limit), jobs), limit)


def scaling_error(shifts: tuple[int, ...], eta: tuple[int, ...], zero: ZeroShift) -> Fraction:
    scaled = [(s, e) for s, e in zip(shifts, eta, strict=True) if s or zero is not ZeroShift.HALVED]
    scaling = prod((1 - e * Fraction(1, 4**s) for s, e in scaled), start=Fraction(1))
    return scaling - 1 / prod((1 + Fraction(1, 4**s) for s, _ in scaled), start=Fraction(1))


def converges(shifts: tuple[int, ...], domain: float) -> bool:
    angles = [atan(2.0**-s) for s in shifts]
    after = [sum(angles[i + 1 :]) + angles[-1] for i in range(len(angles))]
    reached = all(a <= rest + 1e-12 for a, rest in zip(angles, after, strict=True))
    return reached and 2 * (sum(angles) + angles[-1]) >= domain


def brute_force(conditions: Conditions, length: int) -> tuple[int, dict[tuple[int, ...], float]]:
    """Every candidate one by one: how many converge, and the least error of each that can be scaled."""
    converging, least, seen = 0, {}, 0
    allowed = range(conditions.first_shift, conditions.final_shift + 1)
    for head in combinations_with_replacement(allowed, length - 1):
        shifts = (*head, conditions.final_shift)
        scaled = [s for s in shifts if s or conditions.zero is not ZeroShift.HALVED]
        seen += 3 ** len(scaled)
        if converges(shifts, float(conditions.domain_rad)):
            converging += 1
            wanted = 1 / prod(1 + 4.0**-s for s in scaled)
            factors = [(1 - 4.0**-s, 1.0, 1 + 4.0**-s) for s in scaled]
            error = min(abs(prod(chosen) - wanted) for chosen in product(*factors))
            if error <= conditions.scaling_error:
                least[shifts] = error
    assert seen == conditions.candidates(length)
    return converging, least


@pytest.mark.parametrize("zero", ZeroShift)
@pytest.mark.parametrize(
    ("final", "error", "domain"), [(4, Fraction(1, 32), PI), (3, Fraction(1, 500), Fraction(2))]
)
def test_search_is_brute_force(zero: ZeroShift, final: int, error: Fraction, domain: Fraction) -> None:
    conditions = Conditions(final, domain, error, 7, zero)
    found = searched(conditions, limit=1000)
    if zero is not ZeroShift.NONE:  # a search with S = 0 covers the sequences in which it occurs
        found = merge([found, searched(Conditions(final, domain, error, 7), limit=1000)], 1000)
    some = 0
    for length in range(1, 8):
        converging, least = brute_force(conditions, length)
        part = found.get(length)
        assert (converging, len(least)) == ((part.converging, part.scalable) if part else (0, 0))
        if part:
            assert {s.shifts for s in part.best} == set(least)
            for best in part.best:
                assert best.error == scaling_error(best.shifts, best.eta, zero)
                # the nearest in log P is the nearest but for terms of second order
                assert abs(best.error) <= least[best.shifts] + error**2
        some += len(least)
    assert some


def test_the_papers_conditions() -> None:
    found = searched(Conditions(17, PI, ERROR, 22))
    assert [n for n, part in found.items() if part.scalable] == [19, 20, 21, 22]
    paper = abs(
        scaling_error(shift_sequences.KRIEGER96_SHIFTS, shift_sequences.KRIEGER96_ETA, ZeroShift.NONE)
    )
    (best,) = found[22].best
    assert abs(best.error) <= paper
    assert len(best.shifts) == 22
    assert best.shifts[-1] == 17
    assert converges(best.shifts, pi)
    assert best.error == scaling_error(best.shifts, best.eta, ZeroShift.NONE)


def test_the_papers_own_set_is_found() -> None:
    conditions = Conditions(17, PI, ERROR, 22)
    ends = [shift_sequences.KRIEGER96_SHIFTS.count(s) for s in range(17, 0, -1)]
    ours = [t for t in tasks(conditions, 10_000) if list(t.prefix.counts) == ends[: len(t.prefix.counts)]]
    assert len(ours) == 1
    (found,) = [s for s in run(ours[0])[22].best if s.shifts == shift_sequences.KRIEGER96_SHIFTS]
    assert abs(found.error) < Fraction("9.51e-12")


@pytest.mark.parametrize(
    ("zero", "shortest"), [(ZeroShift.NONE, 19), (ZeroShift.SCALED, None), (ZeroShift.HALVED, 18)]
)
def test_shortest(zero: ZeroShift, shortest: int | None) -> None:
    """Sequences in which S = 0 occurs, where it may: scaled like others, it does not do."""
    found = searched(Conditions(17, PI, ERROR, 19, zero))
    assert min((n for n, part in found.items() if part.scalable), default=None) == shortest


def test_jobs_do_not_matter() -> None:
    conditions = Conditions(8, PI, Fraction(1, 2**12), 12, ZeroShift.HALVED)
    assert searched(conditions, 5, jobs=1) == searched(conditions, 5, jobs=3)


def test_list_and_details(golden) -> None:
    golden("sequences/list.txt", invoke().stdout)
    for sequence in shift_sequences.shipped():
        result = invoke(sequence.name)
        assert result.exit_code == 0
        assert "convergence    yes" in result.stdout
    golden("sequences/krieger96.txt", invoke("krieger96").stdout)
    golden("sequences/hyperbolic.txt", invoke("hyperbolic").stdout)


def test_search_text(golden) -> None:
    result = invoke("--search", "--max-iterations", 19, "--jobs", 1, "--limit", 2)
    assert result.exit_code == 0
    assert result.stderr == ""
    golden("sequences/search.txt", result.stdout)


def test_one_of_the_two() -> None:
    small = ["--search", "--final-shift", 6, "--max-iterations", 9, "--scaling-error", "2**-8", "--jobs", 1]
    without, within = invoke(*small, "--no-zero").stdout, invoke(*small, "--allow-zero").stdout
    both = invoke(*small).stdout
    assert "without S = 0" in without
    assert "with S = 0" not in without
    assert "without S = 0" not in within
    head, _, rest = without.partition("\nwithout")
    assert both == head + "\nwithout" + rest + within.removeprefix(head)


def test_nothing_found() -> None:
    result = invoke("--search", "--max-iterations", 8, "--jobs", 1)
    assert result.exit_code == 1
    assert result.stdout.count("shortest: none") == 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nobody"], "E720"),
        (["krieger96", "--search"], "exclude each other"),
        (["--final-shift", "9"], "goes with --search"),
        (["--search", "--domain", "-1"], "E720"),
        (["--search", "--domain", "two"], "E203"),
        (["--search", "--scaling-error", "0"], "E720"),
        (["--search", "--scaling-error", "1/0"], "E209"),
        (["--search", "--final-shift", "0"], "--final-shift"),
    ],
)
def test_bad_usage(arguments: list[str], message: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr
