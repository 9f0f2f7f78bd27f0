"""Time the front end on files of many equations, to see how it grows with their number.

    python benchmarks/frontend.py

Prints, for each shape of file and each number of equations, the processor time to load it in seconds and
the ratio to the time of half as many: about 2 where the growth is linear.
"""

import time
from itertools import pairwise

from cordicc.base.diagnostics import Source
from cordicc.frontend.load import parse_problem

COUNTS = (400, 800, 1600, 3200)
HEAD = "inputs: {x: [0.1, 0.2], y: [0.3, 0.4]}\n"


def chain_of_solves(i: int) -> str:
    written = f"cos(t{i - 1})*cos(t{i}) + y*sin(t{i}) = sin(t{i - 1})/3" if i else "cos(t0) = x"
    return f"- {{solve: {written}, for: t{i}, branch: '+'}}\n"


SHAPES = {
    "chain": lambda i: f"- t{i} = sin(t{i - 1})*y\n" if i else "- t0 = x\n",
    "independent": lambda i: f"- t{i} = sin(x*{i} + 0.5)*y + {i}\n",
    "angles": lambda i: f"- t{i} = t{i - 1}/3 + y\n" if i else "- t0 = asin(x)/2\n",
    "solves": chain_of_solves,
}


def seconds(shape: str, count: int) -> float:
    text = HEAD + "equations:\n" + "".join(map(SHAPES[shape], range(count)))
    text += "outputs: [" + ", ".join(f"t{i}" for i in range(count)) + "]\n"
    start = time.process_time()
    parse_problem(Source("many.yaml", text))
    return time.process_time() - start


def main() -> None:
    print("shape".ljust(14) + "".join(f"{count:>16}" for count in COUNTS))
    for shape in SHAPES:
        times = [seconds(shape, count) for count in COUNTS]
        ratios = [None] + [b / a for a, b in pairwise(times)]
        cells = [
            f"{t:8.2f}" + (f" (x{r:4.2f})" if r else " " * 8) for t, r in zip(times, ratios, strict=True)
        ]
        print(shape.ljust(14) + "".join(cells))


if __name__ == "__main__":
    main()
