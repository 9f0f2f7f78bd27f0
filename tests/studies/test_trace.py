"""Iteration tables: those of the paper, and that every mode computes what it says."""

import math
import re
from dataclasses import replace
from decimal import Decimal

import pytest
from click.testing import Result
from hypothesis import given
from hypothesis import strategies as st

from cordicc.arith.kernels import shift_sequences
from cordicc.studies import iterations
from cordicc.studies.iteration_table import decimal
from tests.support import command_line

# Krieger and Hosticka 1996, as printed: i, x_i, y_i, z_i.
TABLE_2 = """
1 -0.1875 1.3125 0.7144496361
2 -1.08984375 0.59765625 0.2508020271
3 -1.4030914307 0.0163421631 0.005823364
4 -1.3636090793 -0.3294565715 -0.1185316306
5 -1.4024064111 0.0163341845 0.005823364
6 -1.3989700341 -0.15900304223 -0.056595446
7 -1.4133841102 -0.0164620445 -0.05823364
8 -1.4116528153 -0.071820333 -0.0254164695
9 -1.4133814144 0.0164620131 0.005823364
10 -1.4135507884 -0.0277101751 -0.0098003646
11 -1.4140716262 0.0164700522 0.005823364
12 -1.4141563442 -0.0056254788 -0.0019889771
13 -1.4142002936 0.0054227862 0.001917253
14 -1.4142106868 -0.0001014539954 -0.00003587
15 -1.414210885 0.0026606789 0.00094069272
16 -1.4142128089 0.0012796126 0.00045241151
17 -1.4142134337 0.00058907899 0.00020827089
18 -1.4142135354 0.000243812 0.0000862006
19 -1.4142135599 0.000071179 -0.000025165
20 -1.44142135616 -0.000015138 -0.0000053522
21 -1.4142135617 0.0000280202 0.0000099066
22 -1.4142135621 0.000006441 0.0000022772
"""
TABLE_3 = """
1 2.0625 0.375 -0.463647609
2 0.87890625 1.7578125 0
3 1.8093109131 1.2840270996 -0.2449786631
4 2.0692027174 0.7989546284 -0.3693336577
5 2.2016630495 0.2649644973 -0.4936886522
6 2.1599422411 0.5391373609 -0.4312698422
7 2.2188971368 0.2670385755 -0.4936886522
8 2.1978918572 0.40506029108 -0.4624488188
9 2.1683094869 0.541506251 -0.4312089854
10 2.1847021848 0.4736143758 -0.446832714
11 2.169368361 0.5417706906 -0.4312089854
12 2.177568204 0.5078102467 -0.4390213264
13 2.1815355316 0.4907977354 -0.4429275566
14 2.1796017165 0.4993155816 -0.440974434
15 2.1786264898 0.5035726203 -0.4399978718
16 2.1791172209 0.5014448157 -0.4404861531
17 2.1793620671 0.5003807936 -0.4407302937
18 2.1794841654 0.4998487078 -0.440852364
19 2.1794231406 0.5001147563 -0.440807913288
20 2.1794536611 0.4999817339 -0.4408218464
21 2.1794384024 0.5000482455 -0.4408065876
22 2.1794460324 0.5000149898 -0.440814217
"""
MISPRINTS = {  # (table, row, column): what it should be
    (2, 6, "y"): "-0.1590304223",  # one 0 too many
    (2, 7, "y"): "0.0164620445",  # the sign
    (2, 7, "z"): "0.005823364",  # the sign, and a lost 0
    (2, 14, "y"): "-0.000101454",  # digits of another place; likewise to row 19
    (2, 14, "z"): "-0.0000358695",
    (2, 15, "z"): "0.0009406927",
    (2, 16, "z"): "0.0004524115",
    (2, 17, "y"): "0.000589079",
    (2, 17, "z"): "0.0002082709",
    (2, 19, "y"): "0.0000711785",
    (2, 19, "z"): "0.0000251654",
    (2, 20, "x"): "-1.4142135616",  # one 4 too many
    (2, 20, "y"): "-0.0000151382",
    (3, 8, "y"): "0.4050629108",  # one 0 too many
    (3, 19, "z"): "-0.4407913288",  # digits lost and gained
}
TABLES = {
    2: (TABLE_2, ["rotation", "--x", "1", "--y", "1", "--z", "1.1780972451"]),
    3: (TABLE_3, ["implicit", "--x", "1", "--y", "2", "--target", "0.5"]),
}
SHIFTS = [1, 1, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17]
ETA = [1, 1, -1, 1, 1, 0, 0, 1, 1, 0, 0, 1, -1, 1, -1, 1, -1, 1, 0, 1, -1, 1]


def invoke(*arguments: object) -> Result:
    return command_line.run("trace", *arguments)


def rows(text: str) -> list[list[str]]:
    return [line.split() for line in text.splitlines() if re.match(r" *\d+ +-?\d", line)]


def results(text: str) -> list[tuple[float, float]]:
    """The values and the exact values below the table."""
    lines = text.split("  result ")[1].splitlines()[1:]
    return [(float(line.split()[-3]), float(line.split()[-2])) for line in lines]


@pytest.mark.parametrize("table", TABLES)
def test_tables_of_the_paper(table: int, golden) -> None:
    printed, arguments = TABLES[table]
    result = invoke(*arguments, "--sequence", "krieger96")
    assert result.exit_code == 0
    assert result.stderr == ""
    golden(f"trace/table{table}.txt", result.stdout)
    ours = rows(result.stdout)
    assert [int(row[1]) for row in ours] == SHIFTS
    assert [int(row[2]) for row in ours] == ETA
    for row, line in zip(ours, printed.split("\n")[1:-1], strict=True):
        index, *numbers = line.split()
        assert row[0] == index
        for column, number, actual in zip("xyz", numbers, row[3:], strict=True):
            expected = MISPRINTS.get((table, int(index), column), number)
            units = abs(Decimal(actual) - Decimal(expected)) * 10**10
            assert units <= (5 if int(index) > 20 and column != "z" else 1), (index, column, actual, expected)


def test_the_last_printed_rows_lack_their_scaling() -> None:
    """Rows 21 and 22 of both tables are those of η = 0, to the printed digits, not of the printed η."""
    paper = shift_sequences.krieger96()
    unscaled = replace(paper, eta=(*paper.eta[:20], 0, 0))
    number = iterations.mp.mpf
    first = iterations.rotate(unscaled, iterations.State(number(1), number(1), number("1.1780972451")))
    second = iterations.implicit_by_eq9(
        unscaled, iterations.State(number(1), number(2), number(0), number("0.5"))
    )
    for run, printed in ((first, TABLE_2), (second, TABLE_3)):
        for row, line in zip(run.rows[20:], printed.split("\n")[21:23], strict=True):
            for value, digits in zip((row.state.x, row.state.y, row.state.z), line.split()[1:], strict=True):
                assert abs(Decimal(decimal(value)) - Decimal(digits)) * 10**10 <= 1


def test_only_misprints_are_listed() -> None:
    for (table, index, column), right in MISPRINTS.items():
        line = TABLES[table][0].split("\n")[index].split()
        assert line["ixyz".index(column)] != right


CASES = {
    "rotation": ["rotation", "--x", "0.6", "--y", "-0.2", "--z", "pi/3"],
    "rotation.linear": ["rotation", "--x", "0.6", "--y", "-0.2", "--z", "-1.25", "--m", "0"],
    "rotation.hyperbolic": ["rotation", "--x", "0.6", "--z", "0.7", "--m", "-1"],
    "rotation.root-free": ["rotation", "--x", "0.6", "--z", "-3", "--sequence", "root-free"],
    "rotation.root-free-hyperbolic": ["rotation", "--z", "2", "--sequence", "root-free", "--m", "-1"],
    "vectoring": ["vectoring", "--x", "-3", "--y", "4", "--z", "0.25"],
    "vectoring.linear": ["vectoring", "--x", "2", "--y", "1", "--m", "0"],
    "vectoring.hyperbolic": ["vectoring", "--x", "2", "--y", "-1", "--m", "-1"],
    "vectoring.root-free": ["vectoring", "--x", "2", "--y", "1", "--sequence", "root-free"],
    "vectoring.krieger96": ["vectoring", "--x", "2", "--y", "1", "--sequence", "krieger96"],
    "implicit.minus": ["implicit", "--x", "1", "--y", "2", "--target", "0.5"],
    "implicit.plus": ["implicit", "--x", "1", "--y", "2", "--target", "0.5", "--branch", "+"],
    "implicit.root-free": ["implicit", "--x", "-1", "--y", "2", "--target", "-2", "--sequence", "root-free"],
    "implicit.hyperbolic": ["implicit", "--x", "-2", "--y", "1", "--target", "0.5", "--m", "-1"],
    "implicit.hyperbolic-two": ["implicit", "--x", "1", "--y", "2", "--target", "2", "--m", "-1"],
}


@pytest.mark.parametrize("case", CASES)
def test_tables(case: str, golden) -> None:
    result = invoke(*CASES[case])
    assert result.exit_code == 0
    assert result.stderr == ""
    golden(f"trace/{case}.txt", result.stdout)
    for value, exact in results(result.stdout):
        assert value == pytest.approx(exact, abs=6e-5)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("bits", [16, 40])
def test_fixed_point_follows_every_row(case: str, bits: int) -> None:
    """The kernels decide as the exact iterations do, so each row is off by its roundings only."""
    arguments = [*CASES[case], "--iterations", "14"]
    exact, both = invoke(*arguments).stdout, invoke(*arguments, "--bits", bits).stdout
    table = both.removeprefix(exact)
    assert f"units of 2^-{bits}" in table
    lines = [line.split() for line in table.splitlines()[3:]]
    assert [line[0] for line in lines] == ["i", *map(str, range(15))]
    assert max(float(line[-1]) for line in lines[2:]) <= 14


@pytest.mark.parametrize("start", [(-3, 4), (3, -4), (-3, -4), (0, 1), (-1, 0)])
@pytest.mark.parametrize("sequence", ["standard", "root-free", "krieger96"])
def test_fixed_point_vectoring_in_every_quadrant(start: tuple[int, int], sequence: str) -> None:
    x, y = start
    result = invoke("vectoring", "--x", x, "--y", y, "--sequence", sequence, "--bits", 30)
    assert float(result.stdout.split()[-1]) <= 60


def test_fixed_point_table(golden) -> None:
    result = invoke(*TABLES[3][1], "--sequence", "krieger96", "--bits", 24)
    golden("trace/table3.bits.txt", result.stdout)
    mirrored = invoke("implicit", "--x", -1, "--y", 2, "--target", 0.5, "--branch", "+", "--bits", 12)
    golden("trace/implicit.mirrored.bits.txt", mirrored.stdout)


NUMBERS = st.integers(-1000, 1000)
TURNS = st.integers(-1000, 1000)


@pytest.mark.parametrize("sequence", ["root-free", "single-rotation"])
@given(A=NUMBERS, B=NUMBERS, share=TURNS, branch=st.sampled_from("+-"))
def test_implicit_rules_converge(sequence: str, A: int, B: int, share: int, branch: str) -> None:
    """The angle is right within twice the last one, for each branch, and is the formula's own value."""
    C = math.hypot(A, B) * share / 1001
    options = ["--target", f"{C:.15f}", "--branch", branch, "--sequence", sequence]
    result = invoke("implicit", "--x", A, "--y", B, *options)
    if A == B == 0:
        assert "W711" in result.stderr
        return
    assert result.stderr == ""
    (theta, exact), _, _ = results(result.stdout)
    formula = math.atan2(A, B) + (1 if branch == "+" else -1) * math.acos(C / math.hypot(A, B))
    assert exact == pytest.approx(formula, abs=1e-9)
    assert abs(theta - exact) <= 2.0**-16 * 1.001


@given(A=NUMBERS, B=NUMBERS, C=NUMBERS, branch=st.sampled_from("+-"))
def test_hyperbolic_implicit_converges(A: int, B: int, C: int, branch: str) -> None:
    two = abs(B) > abs(A)
    options = ["--branch", branch] if two else []
    result = invoke(
        "implicit", "--x", A, "--y", B, "--target", C, "--m", -1, *options, "--sequence", "root-free"
    )
    assert result.exit_code == 0
    if result.stderr:
        assert "W711" in result.stderr or "W710" in result.stderr
        return
    (theta, exact), _, (_, wanted) = results(result.stdout)
    assert abs(theta - exact) <= 2.0**-16 * 1.001
    assert B * math.cosh(exact) + A * math.sinh(exact) == pytest.approx(wanted, abs=1e-5)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["rotation", "--z", "2"], "W710"),
        (["vectoring", "--x", "3", "--y", "2.9", "--m", "-1"], "W710"),
        (["vectoring", "--x", "1", "--y", "2", "--m", "-1"], "W711"),
        (["vectoring", "--x", "0", "--y", "1", "--m", "0"], "W711"),
        (["implicit", "--x", "1", "--y", "2", "--target", "3"], "W711"),
        (["implicit", "--x", "0", "--y", "0", "--target", "0", "--sequence", "krieger96"], "W711"),
    ],
)
def test_warnings(arguments: list[str], code: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 0
    assert f"warning[{code}]" in result.stderr
    assert "result" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Missing argument"),
        (["turning"], "turning"),
        (["implicit", "--y", "2"], "E713"),
        (["rotation", "--target", "1"], "E713"),
        (["rotation", "--x", "foo"], "E203"),
        (["rotation", "--x", ""], "E112"),
        (["rotation", "--x", "1e12"], "E712"),
        (["rotation", "--sequence", "nobody"], "--sequence"),
        (["rotation", "--sequence", "single-rotation"], "E710"),
        (["rotation", "--sequence", "root-free", "--m", "0"], "E710"),
        (["rotation", "--sequence", "krieger96", "--m", "-1"], "E710"),
        (["rotation", "--sequence", "krieger96", "--iterations", "23"], "E711"),
        (["rotation", "--iterations", "0"], "--iterations"),
        (["rotation", "--branch", "+"], "E714"),
        (["implicit", "--target", "0", "--sequence", "standard"], "E710"),
        (["implicit", "--target", "0", "--m", "0"], "E710"),
        (["implicit", "--target", "0", "--sequence", "krieger96", "--branch", "+"], "E714"),
        (["implicit", "--x", "2", "--y", "1", "--target", "0", "--m", "-1", "--branch", "+"], "E714"),
    ],
)
def test_bad_usage(arguments: list[str], message: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_more_iterations_are_more_accurate() -> None:
    errors = []
    for count in (5, 10, 60):
        result = invoke("rotation", "--z", "1", "--iterations", count)
        assert len(rows(result.stdout)) == count
        value, exact = results(result.stdout)[0]
        errors.append(abs(value - exact))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] == 0
