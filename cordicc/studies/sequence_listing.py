"""`cordicc sequences`: the built-in shift sequences, one of them in detail, and what a search found."""

from __future__ import annotations

from collections.abc import Sequence as Items
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cordicc.arith.kernels import shift_sequences
from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.base.diagnostics import Diagnostic, InvalidInput
from cordicc.base.text_tables import Sheet, Table
from cordicc.studies import sequence_search
from cordicc.studies.iterations import mp
from cordicc.studies.sequence_search import Conditions, Outcome, ScaledSequence, ZeroShift
from cordicc.targets.target import SYSTEMS

_CASES = {
    ZeroShift.NONE: "without S = 0",
    ZeroShift.SCALED: "with S = 0, scaled by 1 - η like the others",
    ZeroShift.HALVED: "with S = 0, a turn by 90 degrees whose factor 2 is dropped (it is in neither product)",
}


@dataclass(frozen=True, slots=True)
class Angle:
    """An iteration's angle beside what must reach it: the sum of the later ones plus the last."""

    shift: int
    angle: Any
    rest: Any


def list_sheet() -> Sheet:
    """Return the table of the built-in sequences."""
    header = ("name", "m", "iterations", "kind", "gain", "domain", "last angle", "scaling error")
    rows: list[tuple[str, ...]] = []
    for sequence in shift_sequences.shipped():
        kind = "root-free" if sequence.root_free else "standard"
        figures = [f"{sequence.gain:.10f}", f"{sequence.domain:.10f}", f"{sequence.resolution:.4g}"]
        error = mp.nstr(abs(_scaling_error(sequence)), 4) if sequence.eta else "-"
        rows.append((sequence.name, str(sequence.m), str(len(sequence.shifts)), kind, *figures, error))
    right = tuple(at for at in range(len(header)) if at not in (0, 3))
    return Sheet("", (Table(header, tuple(rows), indent=0, right=right),))


def _aligned(rows: Items[Items[str]], left: Items[int] = (0, 3)) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [
            f"{c:<{w}}" if i in left else f"{c:>{w}}"
            for i, (c, w) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def _scaling_error(sequence: Sequence) -> Any:
    return mp.mpf(shift_sequences.exact_scaling(sequence)) - 1 / mp.mpf(shift_sequences.exact_gain(sequence))


def angles(sequence: Sequence) -> list[Angle]:
    """Return every angle with what the convergence condition compares it with."""
    found: list[Angle] = []
    rest = mp.mpf(shift_sequences.exact_angle(sequence.m, sequence.shifts[-1], sequence.root_free))
    for shift in reversed(sequence.shifts):
        angle = mp.mpf(shift_sequences.exact_angle(sequence.m, shift, sequence.root_free))
        found.append(Angle(shift, angle, rest))
        rest += angle
    return found[::-1]


def detail_text(name: str) -> str:
    """Return what there is to say about one built-in sequence, ending in a newline.

    Raises:
        InvalidInput: there is no such sequence.
    """
    shipped = {sequence.name: sequence for sequence in shift_sequences.shipped()}
    if name not in shipped:
        raise _invalid(f"there is no sequence '{name[:60]}'", "the sequences are " + ", ".join(shipped))
    sequence = shipped[name]
    kind = "root-free (turns twice the angle of 2^-S)" if sequence.root_free else "standard"
    lines = [f"{name}: {SYSTEMS[sequence.m]} (m = {sequence.m}), {kind}, {len(sequence.shifts)} iterations"]
    lines += [f"  gain           {sequence.gain:.13f}, 1/gain {1 / sequence.gain:.13f}"]
    if sequence.eta:
        scaling, error = (
            mp.nstr(mp.mpf(shift_sequences.exact_scaling(sequence)), 13),
            _scaling_error(sequence),
        )
        lines += [f"  scaling        {scaling}, product of 1 - η 2^-2S; error {mp.nstr(error, 4)}"]
    lines += [f"  domain         {sequence.domain:.10f}, sum of the angles plus the last"]
    lines += [f"  last angle     {sequence.resolution:.4g}"]
    return "\n".join([*lines, f"  convergence    {_verdict(sequence)}", "", *_angle_table(sequence)]) + "\n"


def _verdict(sequence: Sequence) -> str:
    condition = "each angle is at most the sum of the later ones plus the last"
    shortfall = max(a.angle - a.rest for a in angles(sequence))
    if shortfall <= 0:
        return f"yes: {condition}"
    if sequence.converges:
        return f"yes: {condition}, but for {mp.nstr(shortfall, 3)}, under 1/1024 of the last"
    return f"no: an angle exceeds the sum of the later ones plus the last by {mp.nstr(shortfall, 3)}"


def _angle_table(sequence: Sequence) -> list[str]:
    with_eta = bool(sequence.eta)
    rows: list[list[str]] = [["i", "S_i", *(["η_i"] if with_eta else []), "angle", "later + last", "reached"]]
    for i, item in enumerate(angles(sequence)):
        digit = [str(sequence.eta[i])] if with_eta else []
        short = item.angle - item.rest
        reached = "yes" if short <= 0 else f"short by {mp.nstr(short, 3)}"
        figures = [mp.nstr(v, 12, min_fixed=-20, strip_zeros=False) for v in (item.angle, item.rest)]
        rows.append([str(i + 1), str(item.shift), *digit, *figures, reached])
    return _aligned(rows, (len(rows[0]) - 1,))


def conditions(
    final_shift: int, domain: Fraction, scaling_error: Fraction, max_iterations: int, zero: bool | None
) -> list[Conditions]:
    """Return the searches to run: without S = 0, and unless `zero` is false with it, in both meanings.

    Raises:
        InvalidInput: the domain or the error is not in a range that makes sense.
    """
    if not 0 < domain <= 100:
        raise _invalid("--domain must be an angle above 0 and up to 100 rad")
    if not 0 < scaling_error < 1:
        raise _invalid("--scaling-error must be above 0 and below 1")
    cases = [ZeroShift.NONE] if zero is False else list(ZeroShift)
    return [Conditions(final_shift, domain, scaling_error, max_iterations, case) for case in cases]


def _invalid(message: str, hint: str | None = None) -> InvalidInput:
    return InvalidInput([Diagnostic("E720", message, hint=hint)])


def search_head(wanted: Conditions) -> str:
    """Return the stated conditions, ending in a newline."""
    domain, error = (mp.mpf(n.numerator) / n.denominator for n in (wanted.domain_rad, wanted.scaling_error))
    lines = [
        "root-free circular shift sequences S, not falling, with scaling digits η in -1, 0, 1",
        f"  final shift    {wanted.final_shift}",
        f"  iterations     at most {wanted.max_iterations}; a shift may be left out, or repeated at will",
        "  convergence    each angle is at most the sum of the later ones plus the last",
        f"  domain         2 (sum of atan 2^-S + the last) >= {mp.nstr(domain, 11)}",
        f"  scaling        |Π (1 - η 2^-2S) - Π 1/(1 + 2^-2S)| <= {mp.nstr(error, 5)}, absolute",
    ]
    return "\n".join(lines) + "\n"


def search_text(wanted: Conditions, outcome: Outcome) -> str:
    """Return what a search found, ending in a newline."""
    lines = [_CASES[wanted.zero], *("  " + line for line in _counts(wanted, outcome))]
    lines += [f"  {line}" for line in _conclusion(wanted, outcome)]
    for length in outcome.values():
        for found in length.best:
            lines += ["", *_set(wanted, found)]
    return "\n".join(lines) + "\n"


def _counts(wanted: Conditions, outcome: Outcome) -> list[str]:
    """Return the table of lengths; those too short to converge share a row."""
    rows = [("iterations", "shift sequences", "with digits", "converge", "can be scaled")]
    first = min(outcome, default=wanted.max_iterations + 1)
    groups = [range(1, first)] if first > 1 else []
    groups += [range(n, n + 1) for n in range(first, wanted.max_iterations + 1)]
    for group in groups:
        name = str(group[0]) if len(group) == 1 else f"{group[0]} to {group[-1]}"
        length = outcome.get(group[0], sequence_search.Length())
        covered = sum(map(wanted.shift_sequences, group)), sum(map(wanted.candidates, group))
        rows.append(
            (name, f"{covered[0]:,}", f"{covered[1]:,}", f"{length.converging:,}", f"{length.scalable:,}")
        )
    return _aligned(rows, (0,))


def shortest(outcome: Outcome) -> int | None:
    """Return the least number of iterations that meet all conditions."""
    return min((n for n, length in outcome.items() if length.scalable), default=None)


def _conclusion(wanted: Conditions, outcome: Outcome) -> list[str]:
    lengths = range(1, wanted.max_iterations + 1)
    total = sum(map(wanted.candidates, lengths))
    covered = f"covered: all {total:,} candidates of up to {wanted.max_iterations} iterations"
    least = shortest(outcome)
    if least is None:
        return [covered, "shortest: none of them meets all conditions"]
    shorter = sum(map(wanted.candidates, range(1, least)))
    return [covered, f"shortest: {least} iterations; none of the {shorter:,} shorter candidates will do"]


def _set(wanted: Conditions, found: ScaledSequence) -> list[str]:
    error = mp.nstr(mp.mpf(found.error.numerator) / found.error.denominator, 5)
    sequence = Sequence("found", 1, found.shifts, root_free=True)
    halved = wanted.zero is ZeroShift.HALVED
    digits = ["/2" if halved and s == 0 else str(e) for s, e in zip(found.shifts, found.eta, strict=True)]
    widths = [max(len(str(s)), len(d)) for s, d in zip(found.shifts, digits, strict=True)]
    rows = [("S", [str(s) for s in found.shifts]), ("η", digits)]
    head = f"  {len(found.shifts)} iterations: scaling error {error}, domain {sequence.domain:.10f}"
    return [head] + [
        f"    {name} " + " ".join(f"{c:>{w}}" for c, w in zip(cells, widths, strict=True))
        for name, cells in rows
    ]
