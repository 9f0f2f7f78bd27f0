"""Print what rewriting makes of the corpus beside plans by hand, at initiation interval 1.

    python benchmarks/rewriting.py [--target NAME] [--minimize GOAL] [PROBLEM ...]

Columns: CAUs / multipliers of two variables / CAUs on the longest path of the plan; the same of the
plan by hand; CAUs with shared subexpressions only and standard CAUs, and with implicit CAUs and
merged vectorings (both counted by hand); whether the choice is proven the cheapest of the alternatives
found; seconds for rewriting alone.  Rows that need more than the plan by hand are marked with what
they need more of.  Problems whose plan by hand rests on facts about the inputs are taken from
`tests/whole/facts`, where `assume` states those facts.
"""

import argparse
import time
from pathlib import Path

from cordicc.frontend.load import load_problem
from cordicc.ir.graph import Graph
from cordicc.ir.problem import input_intervals
from cordicc.rewrite.cheapest import Choice, cheapest
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import through_passes
from cordicc.rewrite.same_meaning import check_meaning
from cordicc.rewrite.search.costs import UNITS, Costs
from cordicc.targets.target_file import load_target

ROOT = Path(__file__).resolve().parents[1]

BY_HAND = {
    # name: (shared subexpressions, implicit CAUs and pairs, (CAUs, multipliers, depth) by hand)
    "planar_2r": (5, 4, (2, 2, 1)),
    "planar_2r_solve": (5, 3, (2, 2, 1)),
    "planar_3r": (6, 5, (3, 2, 2)),
    "scara": (6, 5, (3, 2, 2)),
    "anthropomorphic_3r": (5, 4, (3, 2, 2)),
    "wrist_zyz": (4, 3, (3, 0, 1)),
    "puma560": (12, 10, (6, 24, 4)),
    "puma560_solve": (14, 9, (6, 24, 4)),
    "stanford_arm": (11, 7, (5, 20, 4)),
    "franka_panda_q7": (19, 14, (7, 42, 5)),
    "humanoid_leg_6dof": (13, 10, (6, 19, 2)),
    "delta_rotary": (9, 3, (3, 3, 1)),
    "stewart_legs": (9, 9, (9, 15, 3)),
    "double_wishbone_2d": (6, 4, (3, 0, 2)),
    "four_bar": (6, 4, (3, 0, 2)),
    "four_bar_freudenstein": (6, 4, (3, 0, 2)),
    "slider_crank": (4, 3, (2, 0, 2)),
    "quick_return": (4, 4, (4, 0, 4)),
    "quadruped_leg": (9, 6, (3, 2, 2)),
    "ackermann": (8, 8, (4, 0, 2)),
    "cable_winch": (4, 4, (4, 2, 2)),
    "five_axis_ac_trunnion": (5, 4, (3, 3, 2)),
    "antenna_az_el_geo": (5, 3, (3, 0, 3)),
    "geodetic_to_ecef": (4, 4, (4, 2, 4)),
    "foc_park_clarke": (1, 1, (1, 6, 1)),
    "magnetic_encoder": (3, 3, (0, 0, 0)),
    "catenary": (4, 3, (2, 0, 2)),
    "catenary_two_supports": (6, 4, (3, 0, 3)),
    "lorentz_boost": (2, 2, (2, 2, 2)),
    "quat_from_rpy": (3, 3, (3, 0, 2)),
    "wheel_suspension": (7, 5, (2, 1, 1)),
}


def figures(graph: Graph) -> tuple[int, int, int]:
    """Return CAUs, multipliers of two variables, and the most CAUs on a path."""
    live = graph.live()
    depth = [0] * len(graph.nodes)
    for index, node in enumerate(graph.nodes):
        depth[index] = max((depth[v.node] for v in node.operands), default=0) + (node.op in UNITS)
    nodes = [graph.nodes[i] for i in live]
    caus = sum(node.op in UNITS for node in nodes)
    return caus, sum(node.op == "mul" for node in nodes), max(depth[i] for i in live)


def rewritten(name: str, target: str, goal: str) -> tuple[Choice, float]:
    places = [ROOT / "tests" / "whole" / "facts", ROOT / "tests" / "whole" / "corpus", ROOT / "examples"]
    path = next(p / f"{name}.yaml" for p in places if (p / f"{name}.yaml").exists())
    problem = load_problem(path).problem
    loaded = load_target(target)
    context = PassContext(input_intervals(problem), goal)
    start = time.perf_counter()
    graph = through_passes(problem.graph, context, implicit=loaded.has_implicit)
    choice = cheapest(problem, graph, context, Costs.of(loaded, implicit=loaded.has_implicit))
    seconds = time.perf_counter() - start
    check_meaning(problem, choice.graph)
    return choice, seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target", default="kinematic")
    parser.add_argument("--minimize", default="processors")
    parser.add_argument("problems", nargs="*")
    options = parser.parse_args()
    print("{:24}{:>12}{:>12}{:>9}{:>9}{:>9}{:>8}  note".format(*HEADER))
    totals = [0, 0, 0, 0]
    sums = [(0, 0, 0), (0, 0, 0)]
    for name, (shared, paired, hand) in BY_HAND.items():
        if options.problems and name not in options.problems:
            continue
        choice, seconds = rewritten(name, options.target, options.minimize)
        ours = figures(choice.graph)
        more = [what for what, a, b in zip(("CAUs", "mul", "depth"), ours, hand, strict=True) if a > b]
        for index, number in enumerate((ours[0], hand[0], shared, paired)):
            totals[index] += number
        sums = [(a[0] + b[0], a[1] + b[1], a[2] + b[2]) for a, b in zip(sums, (ours, hand), strict=True)]
        shown = ["/".join(map(str, each)) for each in (ours, hand)]
        proven = "yes" if choice.proven else "no"
        print(f"{name:24}{shown[0]:>12}{shown[1]:>12}{shared:9}{paired:9}{proven:>9}{seconds:8.2f}", end="")
        print("  more " + ", ".join(more) if more else "", flush=True)
    shown = ["/".join(map(str, each)) for each in sums]
    print(f"{'sum':24}{shown[0]:>12}{shown[1]:>12}{totals[2]:9}{totals[3]:9}")
    print(f"CAUs in all: {totals[0]}, by hand {totals[1]}, shared {totals[2]}, paired {totals[3]}")


HEADER = ("problem", "rewritten", "by hand", "shared", "paired", "proven", "s")

if __name__ == "__main__":
    main()
