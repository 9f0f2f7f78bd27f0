"""Write `puma560.samples.csv`: poses of the hand, by forward kinematics of random joint angles.

Most are well inside the joint limits.  The last ones are where errors are amplified: the wrist is straight or
nearly so, where only the sum of q4 and q6 turns the hand, and the arm is nearly stretched or folded.
"""

import csv
import math
import random
from pathlib import Path

D1, A2, A3, D3, D4 = 0.67183, 0.4318, 0.0203, 0.15005, 0.4318
LINKS = (  # twist, length, offset of each joint, as in puma560.yaml
    (math.pi / 2, 0, D1),
    (0, A2, 0),
    (-math.pi / 2, A3, D3),
    (math.pi / 2, 0, D4),
    (-math.pi / 2, 0, 0),
    (0, 0, 0),
)
LIMITS = ((-2.7, 2.7), (-0.8, 2.2), (-1.3, 1.4), (-1.9, 1.9), (0.2, 1.7), (-3.0, 3.0))  # rad
PLACE = ((-0.9, 0.9), (-0.9, 0.9), (-0.2, 1.55))  # the ranges of px, py, pz
ROWS = 256
WRISTS = (0.0, 1e-7, 1e-5, 1e-3)  # q5, from straight
STRETCHED, FOLDED = math.atan2(-D4, A3), math.atan2(D4, -A3)
ELBOWS = (  # q3
    *(STRETCHED + bend for bend in (1e-1, 1e-2, 3e-3, 1e-3)),
    *(FOLDED - bend for bend in (3e-1, 1e-1, 3e-2)),
)
HARD_ROWS = 8  # of each
COLUMNS = [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)] + ["px", "py", "pz"]


def pose(angles: list[float]) -> list[float]:
    """Return the rotation matrix by rows, then the place in metres."""
    turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    place = [0.0, 0.0, 0.0]
    for angle, (twist, length, offset) in zip(angles, LINKS, strict=True):
        c, s, ct, st = math.cos(angle), math.sin(angle), math.cos(twist), math.sin(twist)
        step = ((c, -s * ct, s * st), (s, c * ct, -c * st), (0.0, st, ct))
        move = (length * c, length * s, offset)
        place = [place[i] + sum(turn[i][k] * move[k] for k in range(3)) for i in range(3)]
        turn = [[sum(row[k] * step[k][j] for k in range(3)) for j in range(3)] for row in turn]
    return [max(-1.0, min(1.0, r)) for row in turn for r in row] + place


def main() -> None:
    """Draw joint angles until enough of them reach forward and lie inside the ranges."""
    draw = random.Random(560)
    hard = [(4, q5) for q5 in WRISTS] + [(2, q3) for q3 in ELBOWS]
    fixed: list[tuple[int, float] | None] = [None] * ROWS + [each for each in hard for _ in range(HARD_ROWS)]
    rows: list[list[float]] = []
    while len(rows) < len(fixed):
        angles = [draw.uniform(low, high) for low, high in LIMITS]
        if (joint := fixed[len(rows)]) is not None:
            angles[joint[0]] = joint[1]
        q23 = angles[1] + angles[2]
        reach = A2 * math.cos(angles[1]) + A3 * math.cos(q23) - D4 * math.sin(q23)
        row = pose(angles)
        least = 0.1 if len(rows) < ROWS else 0.001
        if reach > least and all(low <= p <= high for p, (low, high) in zip(row[9:], PLACE, strict=True)):
            rows.append(row)
    with Path(__file__).with_name("puma560.samples.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()
