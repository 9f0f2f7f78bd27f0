"""Time and memory of every hostile case of tests/support/hostile, the worst ones first.

    python benchmarks/hostile.py [PATTERN]

A case that crashes, or ends otherwise than it should, is marked.  PATTERN picks cases by a part of their
names.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.support.hostile.catalogue import CASES
from tests.support.hostile.running import run

SHOWN = 25


def main() -> None:
    wanted = sys.argv[1] if len(sys.argv) > 1 else ""
    rows = []
    for case in CASES:
        if wanted not in case.name:
            continue
        with tempfile.TemporaryDirectory() as name:
            case.lay_out(Path(name))
            ended = run(case.arguments, Path(name))
        good = not ended.crashed and case.fits(ended.status, ended.codes)
        told = ",".join(dict.fromkeys(ended.codes))
        rows.append((ended.cpu_seconds, ended.peak_bytes, ended.status, told, case.name, good))
        if not good:
            print(
                f"NOT AS IT SHOULD BE: {case.name}: status {ended.status}\n{ended.stderr[-800:]}", flush=True
            )
    print(f"{'CPU s':>8} {'MB':>6} {'exit':>4}  {'codes':16} case")
    for cpu, peak, status, told, name, good in sorted(rows, reverse=True)[:SHOWN]:
        print(f"{cpu:8.2f} {peak / 1e6:6.0f} {status:4}  {told[:16]:16} {name}{'' if good else '  !'}")
    if rows:
        print(
            f"{len(rows)} cases, {sum(not row[-1] for row in rows)} not as they should be; longest "
            f"{max(row[0] for row in rows):.1f} s, most memory {max(row[1] for row in rows) / 1e6:.0f} MB"
        )
    sys.exit(any(not row[-1] for row in rows))


if __name__ == "__main__":
    main()
