"""Build plans of a single CORDIC unit for a chip, and compare the clock that closes with the one asked for.

    python benchmarks/units_clock.py [--device ecp5-85k] [--target ecp5] [--clocks 80,100,150] [--width 24]

Each plan is one operation on inputs of one range.  Its cycles follow from the clock and the delays of the
device, see `cordicc.arith.circuits.cell_delays`; place and route tell what closes.  Needs yosys and nextpnr.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cordicc
from cordicc.backends.synthesis.build import built
from cordicc.targets.device import DEVICES

VECTOR = "inputs: {x: [-1, 1], y: [-1, 1]}\n"
TURNED = "inputs: {x: [-1, 1], y: [-1, 1], z: [-3.1, 3.1]}\n"
SOLVED = "inputs: {A: [-1, 1], B: [-1, 1], C: [-1, 1]}\n"

PROBLEMS = {
    "vectoring": VECTOR + "equations: ['r = hypot(x, y)', 't = atan2(y, x)']\noutputs: [r, t]\n",
    "rotation": TURNED
    + "equations: ['u = x*cos(z) - y*sin(z)', 'v = x*sin(z) + y*cos(z)']\noutputs: [u, v]\n",
    "implicit": SOLVED + "equations: [{solve: 'B*cos(t) + A*sin(t) = C', for: t}]\noutputs: [t]\n",
}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--device", default="ecp5-85k", choices=list(DEVICES))
    parser.add_argument("--target", default="ecp5")
    parser.add_argument("--clocks", default="80,100,150", help="in MHz")
    parser.add_argument("--width", type=int, default=24)
    parser.add_argument("--units", default=",".join(PROBLEMS))
    options = parser.parse_args()
    print(
        f"{'unit':10} {'MHz':>5} {'cycles':>6} {'LUT':>6} {'FF':>6} {'DSP':>4} {'closes at':>9}", flush=True
    )
    for name in options.units.split(","):
        for clock in options.clocks.split(","):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / f"{name}.yaml"
                path.write_text(PROBLEMS[name], encoding="utf-8")
                plan = cordicc.compile(
                    path,
                    target=options.target,
                    certify=False,
                    width=options.width,
                    clock_hz=float(clock) * 1e6,
                )
                device = DEVICES[options.device]
                result, _ = built(plan, device, place=True, seed=1, enter=lambda _: None)
            area, hertz = result.area, result.clock_hz
            reached = "-" if hertz is None else f"{hertz / 1e6:.1f}"
            row = f"{name:10} {clock:>5} {plan.latency_cycles:6} {area.lut:6} {area.ff:6} {area.dsp:4}"
            print(f"{row} {reached:>9}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
