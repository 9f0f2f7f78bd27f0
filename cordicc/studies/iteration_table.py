"""`cordicc trace`: iteration tables as Krieger and Hosticka 1996 print them, and what they amount to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from cordicc.arith.kernels import shift_sequences
from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity
from cordicc.studies import fixed_iterations, iterations
from cordicc.studies.iterations import IterationRun, State, mp
from cordicc.targets.target import SYSTEMS

LARGEST = 10**9
DECIMALS = 10

RULES = {
    "krieger96": "root-free, scaled within the iterations",
    "standard": "standard micro-rotations",
    "root-free": "root-free double rotations",
    "single-rotation": "standard micro-rotations",
}
GOALS = {"rotation": "z -> 0", "vectoring": "y -> 0", "implicit": "y -> C"}


@dataclass(frozen=True, slots=True)
class Request:
    """What is to be traced: a mode, a sequence, coordinate system m, and the start.

    `iterations` None stands for the sequence's own number, `branch` None for "-" where there are two.
    `bits` are the fraction bits of a run in fixed point to be shown below.
    """

    mode: str
    sequence: str
    m: int
    x: Fraction
    y: Fraction
    z: Fraction
    target: Fraction | None = None
    iterations: int | None = None
    branch: str | None = None
    bits: int | None = None


@dataclass(frozen=True, slots=True)
class Result:
    """One result: what it stands for, its value, and the exact one (None: there is none)."""

    name: str
    value: Any
    exact: Any


def trace_text(request: Request) -> tuple[str, list[Diagnostic]]:
    """Return the table with its summary, ending in a newline, and warnings.

    Raises:
        InvalidInput: the mode, the sequence and the other options do not go together.
    """
    sequence = _sequence(request)
    start = _start(request)
    branch = _branch(request)
    run = _run(request, sequence, start, branch)
    results = _results(request, sequence, start, run, branch)
    lines = [*_head(request, sequence, start, run), "", *_table(run, sequence), "", *_facts(sequence)]
    lines += ["", *_result_table(results)]
    if request.bits is not None:
        lines += ["", *_fixed_point(request.mode, sequence, run, request.bits)]
    return "\n".join(lines) + "\n", _warnings(request, sequence, start, run, results)


def _invalid(code: str, message: str, hint: str | None = None) -> InvalidInput:
    return InvalidInput([Diagnostic(code, message, hint=hint)])


def _sequence(request: Request) -> Sequence:
    """Return the sequence asked for, of the length asked for."""
    mode, name, m = request.mode, request.sequence, request.m
    if mode == "implicit" and name == "standard":
        hint = "'single-rotation' has standard micro-rotations and scales the target"
        raise _invalid("E710", "the standard sequence has no implicit rule", hint)
    if mode != "implicit" and name == "single-rotation":
        raise _invalid(
            "E710", "'single-rotation' is a rule for implicit equations", "use --sequence standard"
        )
    if (
        (name == "krieger96" and m != 1)
        or (name == "root-free" and m == 0)
        or (mode == "implicit" and m == 0)
    ):
        raise _invalid("E710", f"{mode} by '{name}' has no {SYSTEMS[m]} iterations (m = {m})")
    if name == "krieger96":
        return _shortened(shift_sequences.krieger96(), request.iterations)
    count = request.iterations or (19 if m == -1 else 18)
    return shift_sequences.root_free(m, count) if name == "root-free" else shift_sequences.standard(m, count)


def _shortened(sequence: Sequence, iterations: int | None) -> Sequence:
    count = len(sequence.shifts)
    if iterations is not None and iterations > count:
        raise _invalid("E711", f"'{sequence.name}' has {count} iterations, not {iterations}")
    wanted = iterations or count
    return replace(sequence, shifts=sequence.shifts[:wanted], eta=sequence.eta[:wanted])


def _start(request: Request) -> State:
    numbers = {"x": request.x, "y": request.y, "z": request.z, "target": request.target}
    for name, number in numbers.items():
        if number is not None and abs(number) > LARGEST:
            raise _invalid("E712", f"--{name} is larger than {LARGEST:g} in magnitude")
    if request.mode == "implicit" and request.target is None:
        raise _invalid("E713", "implicit needs --target, the C of B cos t + A sin t = C")
    if request.mode != "implicit" and request.target is not None:
        raise _invalid("E713", f"{request.mode} takes no --target")
    return State(*(None if n is None else mp.mpf(n.numerator) / n.denominator for n in numbers.values()))


def _branch(request: Request) -> str:
    """Return the branch of an implicit equation; any value where there is none to choose."""
    why = ""
    if request.mode != "implicit":
        why = f"{request.mode} takes no --branch"
    elif request.sequence == "krieger96":
        why = "the paper's rule takes no --branch: which solution comes out depends on the data"
    elif request.m == -1 and abs(request.y) <= abs(request.x):
        why = "with |x| >= |y| a hyperbolic equation has one solution and takes no --branch"
    if why and request.branch is not None:
        raise _invalid("E714", why)
    return request.branch or "-"


def _run(request: Request, sequence: Sequence, start: State, branch: str) -> IterationRun:
    if request.mode == "rotation":
        return iterations.rotate(sequence, start)
    if request.mode == "vectoring":
        return iterations.vector(sequence, start)
    if request.sequence == "krieger96":
        return iterations.implicit_by_eq9(sequence, start)
    return iterations.implicit(sequence, start, branch)


def _results(
    request: Request, sequence: Sequence, start: State, run: IterationRun, branch: str
) -> list[Result]:
    """Return what the last row stands for, with stretch and halved angles taken out."""
    end = run.end
    gain = 1 if sequence.eta else mp.mpf(shift_sequences.exact_gain(sequence))
    double = 2 if iterations.halves_angles(sequence) else 1
    twice = "2 " if double == 2 else ""
    over = "" if sequence.eta else "/gain"
    if request.mode == "rotation":
        x, y = _rotated(sequence.m, start.x, start.y, double * start.z)
        return [
            Result(f"x{over} = {_formula(sequence.m, 'x', twice)}", end.x / gain, x),
            Result(f"y{over} = {_formula(sequence.m, 'y', twice)}", end.y / gain, y),
            Result(f"{twice}z, left to turn", double * end.z, mp.mpf(0)),
        ]
    turned = double * end.z
    if request.mode == "vectoring":
        norm, angle = _polar(sequence.m, start)
        exact = None if angle is None else double * start.z + angle
        return [
            Result(f"x{over} = {_NORMS[sequence.m]}", end.x / gain, norm),
            Result(f"y{over}, left to turn", end.y / gain, mp.mpf(0)),
            Result(f"{twice}z = {twice}z0 + {_ANGLES[sequence.m]}", turned, exact),
        ]
    theta, root = _solution(request, start, end, branch, double)
    side = -1 if run.negated else 1
    residual = _rotated(sequence.m, start.x, start.y, turned - double * start.z)[1]
    formula = "B cos t + A sin t" if sequence.m > 0 else "B cosh t + A sinh t"
    return [
        Result(f"{twice}z = {twice}z0 + t", turned, None if theta is None else double * start.z + theta),
        Result(f"x{over} = {_ROOTS[sequence.m]}", side * end.x / gain, root),
        Result(f"{formula}, A = x0, B = y0", residual, start.target),
    ]


_NORMS = {1: "sgn(x0) sqrt(x0^2 + y0^2)", 0: "x0", -1: "sgn(x0) sqrt(x0^2 - y0^2)"}
_ANGLES = {1: "atan(y0/x0)", 0: "y0/x0", -1: "atanh(y0/x0)"}
_ROOTS = {1: "A cos t - B sin t", -1: "A cosh t + B sinh t"}


def _formula(m: int, component: str, twice: str) -> str:
    """Return what a component of the rotated vector is."""
    if m == 0:
        return "x0" if component == "x" else "y0 + x0 z0"
    cos, sin = (f"cos {twice}z0", f"sin {twice}z0") if m == 1 else ("cosh z0", "sinh z0")
    if component == "x":
        return f"x0 {cos} {'-' if m == 1 else '+'} y0 {sin}"
    return f"y0 {cos} + x0 {sin}"


def _rotated(m: int, x: Any, y: Any, angle: Any) -> tuple[Any, Any]:
    if m == 0:
        return x, y + x * angle
    cos, sin = (mp.cos(angle), mp.sin(angle)) if m == 1 else (mp.cosh(angle), mp.sinh(angle))
    return x * cos - m * y * sin, y * cos + x * sin


def _polar(m: int, start: State) -> tuple[Any, Any]:
    """Return the signed norm and the angle, each None where it does not exist."""
    x, y = start.x, start.y
    side = -1 if x < 0 else 1
    if m == 1:
        angle = mp.atan2(side * y, side * x) if x or y else None
        return side * mp.hypot(x, y), angle
    if m == 0:
        return x, (y / x if x else None)
    if abs(y) > abs(x):
        return None, None
    return side * mp.sqrt(x * x - y * y), (mp.atanh(y / x) if abs(y) < abs(x) else None)


def _solution(request: Request, start: State, end: State, branch: str, double: int) -> tuple[Any, Any]:
    """Return t of the equation and A cos t - B sin t (A cosh t + B sinh t); None without solution."""
    theta = _hyperbolic_angle(start, branch) if request.m == -1 else _circular_angle(start, branch)
    if theta is None:
        return None, None
    if request.sequence == "krieger96":  # whichever solution it went for
        theta = _nearest(start, double * (end.z - start.z))
    return theta, _rotated(request.m, start.x, start.y, theta)[0]


def _circular_angle(start: State, branch: str) -> Any:
    A, B, C = start.x, start.y, start.target
    norm = mp.hypot(A, B)
    if not norm or abs(C) > norm:
        return None
    return mp.atan2(A, B) + (-1 if branch == "-" else 1) * mp.acos(C / norm)


def _nearest(start: State, angle: Any) -> Any:
    """Return the solution nearest to an angle, modulo a turn."""
    turn = 2 * mp.pi
    solutions = [_circular_angle(start, branch) for branch in "-+"]
    solutions = [t + turn * mp.nint((angle - t) / turn) for t in solutions]
    return min(solutions, key=lambda t: abs(t - angle))


def _hyperbolic_angle(start: State, branch: str) -> Any:
    """Return the solution of B cosh t + A sinh t = C; None if there is none."""
    A, B, C = start.x, start.y, start.target
    if abs(A) > abs(B):
        side = -1 if A < 0 else 1
        return mp.asinh(side * C / mp.sqrt(A * A - B * B)) - mp.atanh(B / A)
    if abs(A) == abs(B):
        return None if not B or C / B <= 0 else mp.log(C / B) * (1 if A == B else -1)
    ratio = C / mp.sqrt(B * B - A * A) * (-1 if B < 0 else 1)
    return None if ratio < 1 else -mp.atanh(A / B) + (-1 if branch == "-" else 1) * mp.acosh(ratio)


def _head(request: Request, sequence: Sequence, start: State, run: IterationRun) -> list[str]:
    title = f"{request.mode} ({GOALS[request.mode]}) by {request.sequence}: {SYSTEMS[sequence.m]}, "
    title += f"{RULES[request.sequence]}, {len(sequence.shifts)} iterations"
    lines = [title, f"  start   {_values(start)}"]
    if run.preparation:
        lines += [f"  begins  {_values(run.start)} ({run.preparation})"]
    return lines


def _values(state: State) -> str:
    named = [("x0", state.x), ("y0", state.y), ("z0", state.z), ("C", state.target)]
    return ", ".join(f"{name} = {decimal(value)}" for name, value in named if value is not None)


def decimal(value: Any) -> str:
    """Return a number with ten decimals, correctly rounded, without a sign if that gives 0."""
    units = int(mp.nint(value * 10**DECIMALS))
    whole, part = divmod(abs(units), 10**DECIMALS)
    return f"{'-' if units < 0 else ''}{whole}.{part:0{DECIMALS}}"


def _scales_target(run: IterationRun, sequence: Sequence) -> bool:
    return run.start.target is not None and not sequence.eta


def _table(run: IterationRun, sequence: Sequence) -> list[str]:
    scaled_target = _scales_target(run, sequence)
    header = ["i", "S_i", *(["η_i"] if sequence.eta else []), "x_i", "y_i", "z_i"]
    table = [header + (["C_i"] if scaled_target else [])]
    for row in run.rows:
        numbers = [row.state.x, row.state.y, row.state.z, *([row.state.target] if scaled_target else [])]
        counts = [row.index, row.shift, *([] if row.eta is None else [row.eta])]
        table.append([str(n) for n in counts] + [decimal(n) for n in numbers])
    return _to_the_right(table)


def _to_the_right(table: list[list[str]]) -> list[str]:
    widths = [max(len(line[i]) for line in table) for i in range(len(table[0]))]
    return ["  ".join(f"{cell:>{w}}" for cell, w in zip(line, widths, strict=True)) for line in table]


def _fixed_point(mode: str, sequence: Sequence, run: IterationRun, bits: int) -> list[str]:
    """Return the same iterations on integers, and how far they are from the exact ones."""
    start, rows = fixed_iterations.fixed_rows(mode, sequence, run, bits)
    names = ["x", "y", "z", *(["target"] if _scales_target(run, sequence) else [])]
    table = [["i", *(f"{'C' if n == 'target' else n}_i" for n in names), "off by"]]
    table.append(["0", *(str(getattr(start, n)) for n in names), ""])
    for row, words in zip(run.rows, rows, strict=True):
        exact = [mp.ldexp(getattr(row.state, n), bits) for n in names]
        off = max(abs(getattr(words, n) - e) for n, e in zip(names, exact, strict=True))
        table.append([str(row.index), *(str(getattr(words, n)) for n in names), mp.nstr(off, 3)])
    head = f"in fixed point, units of 2^-{bits}; shifts round half up, 'off by' is the largest difference"
    return [head, "", *_to_the_right(table)]


def _facts(sequence: Sequence) -> list[str]:
    """Return gain, scaling and domain of the sequence."""
    gain = mp.mpf(shift_sequences.exact_gain(sequence))
    lines = [f"  gain    {decimal(gain)}" + ("" if sequence.eta else ", left in x, y and the target")]
    if sequence.eta:
        scaling = mp.mpf(shift_sequences.exact_scaling(sequence))
        error = mp.nstr(abs(scaling - 1 / gain), 4)
        lines.append(f"  scaling {decimal(scaling)}, within {error} of 1/gain")
        lines.append("  angles  z counts half of what the vector turns")
    last = iterations.counted_angle(sequence, sequence.shifts[-1])
    lines.append(f"  domain  |z| <= {decimal(domain(sequence))}, last angle {mp.nstr(last, 4)}")
    return lines


def domain(sequence: Sequence) -> Any:
    """Return the largest z that the iterations drive to 0, as they count it."""
    angles = [iterations.counted_angle(sequence, s) for s in sequence.shifts]
    return sum(angles) + angles[-1]


def _result_table(results: list[Result]) -> list[str]:
    rows = [("result", "value", "exact", "error")]
    for result in results:
        exact, error = "none", "-"
        if result.exact is not None:
            exact, error = decimal(result.exact), mp.nstr(result.value - result.exact, 3)
        rows.append((result.name, decimal(result.value), exact, error))
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    return [f"  {r[0]:<{widths[0]}}  {r[1]:>{widths[1]}}  {r[2]:>{widths[2]}}  {r[3]}" for r in rows]


def _warnings(
    request: Request, sequence: Sequence, start: State, run: IterationRun, results: list[Result]
) -> list[Diagnostic]:
    """Return warnings: no exact result, the domain exceeded, or a rule that failed."""
    if any(result.exact is None for result in results):
        what = {"implicit": "the equation has no solution", "vectoring": "the vector has no such angle"}
        return [_warning("W711", f"{what[request.mode]}: the last row means nothing")]
    reach = domain(sequence)
    needed = _needed(request, start, run, results)
    if abs(needed) > reach:
        message = f"{decimal(abs(needed))} to turn exceeds the convergence domain {decimal(reach)}"
        return [_warning("W710", message, "reduce the argument first, or use another sequence")]
    if request.sequence == "krieger96" and request.mode == "implicit":
        limit = 4 * iterations.counted_angle(sequence, sequence.shifts[-1]) * mp.hypot(start.x, start.y)
        if abs(run.end.y - start.target) > limit:
            hint = "the norm is right only after the last step, so earlier comparisons may be wrong"
            return [_warning("W712", "the paper's rule did not converge to the target", hint)]
    return []


def _needed(request: Request, start: State, run: IterationRun, results: list[Result]) -> Any:
    """Return the angle that the iterations have to turn, as z counts it."""
    double = 2 if request.sequence == "krieger96" else 1
    if request.mode == "rotation":
        return start.z
    if request.mode == "vectoring":
        return results[2].exact / double - start.z
    return results[0].exact / double - run.start.z


def _warning(code: str, message: str, hint: str | None = None) -> Diagnostic:
    return Diagnostic(code, message, hint=hint, severity=Severity.WARNING)
