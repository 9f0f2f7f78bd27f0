"""Do two states of cordicc write the same files? The check of a change that moves code but no behaviour.

    python benchmarks/same_bytes.py write before            # with the cordicc of this environment
    python benchmarks/same_bytes.py write after             # with the other one
    python benchmarks/same_bytes.py compare before after    # exit status 1 if any file differs

Every problem of the corpus and the examples is compiled for each target at each interval, with the C model,
in a process of its own, as a user would; the pictures, the graph among them, are drawn, and each plan is run
clock by clock on a few samples, with its outputs and a waveform. What a run says and its exit status are kept
too.
"""

import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from subprocess import run

import click

ROOT = Path(__file__).resolve().parent.parent
PROBLEMS = ("tests/whole/corpus/*.yaml", "examples/*.yaml")
TARGETS = ("kinematic", "fixed24", "imscor24")
INTERVALS = (1, 4)
CLOCKED = "--cycle-accurate --random 20 --no-reference --outputs outputs.csv"
CLOCKED += " --vcd waveform.vcd --vcd-samples 5"


@click.group()
def main() -> None:
    """Write all files of a state of cordicc, and compare two such folders."""


@main.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.argument("problems", nargs=-1, type=click.Path(path_type=Path, exists=True, dir_okay=False))
@click.option("--effort", default="1", show_default=True, help="Work of the searches, as in cordicc compile.")
@click.option("--jobs", default=1, show_default=True, help="Compilers at a time.")
def write(folder: Path, problems: tuple[Path, ...], effort: str, jobs: int) -> None:
    """Compile PROBLEMS (default: corpus and examples) into FOLDER."""
    every = [path for pattern in PROBLEMS for path in sorted(ROOT.glob(pattern))]
    cases = list(product(problems or every, TARGETS, INTERVALS))
    with ThreadPoolExecutor(jobs) as pool:
        failed = sum(pool.map(lambda case: _compiled(folder, *case, effort=effort), cases))
    print(f"{len(cases)} compilations, {failed} of them refused")


def _compiled(folder: Path, problem: Path, target: str, interval: int, *, effort: str) -> bool:
    """Whether one problem was refused; its files are in a folder named after the case."""
    place = folder.resolve() / f"{problem.parent.name}.{problem.stem}" / f"{target}.{interval}"
    place.mkdir(parents=True, exist_ok=True)
    options = ["--target", target, "--ii", str(interval), "--effort", effort, "--emit", "c"]
    # A relative name, so that what is said holds no path of the machine.
    said = _told(["compile", problem.name, *options, "-o", str(place / "files")], problem.parent)
    said = said.replace(str(place), "PLACE")
    if (place / "files" / "plan.json").exists():
        said += _told(["draw", "plan.json", "--view", "graph", "-o", "graph.svg"], place / "files")
        said += _told(["simulate", "plan.json", *CLOCKED.split()], place / "files")
    (place / "said.txt").write_text(said, encoding="utf-8")
    return not (place / "files" / "plan.json").exists()


def _told(arguments: list[str], folder: Path) -> str:
    done = run(
        [sys.executable, "-m", "cordicc", *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    return f"exit status {done.returncode}\n{done.stdout}{done.stderr}"


@main.command()
@click.argument("before", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.argument("after", type=click.Path(path_type=Path, file_okay=False, exists=True))
def compare(before: Path, after: Path) -> None:
    """Compare all files below BEFORE with those below AFTER."""
    names = sorted(
        {str(path.relative_to(top)) for top in (before, after) for path in top.rglob("*") if path.is_file()}
    )
    same: Counter[str] = Counter()
    different: Counter[str] = Counter()
    for name in names:
        pair = before / name, after / name
        kind = Path(name).name if Path(name).suffix not in (".c", ".h") else f"*{Path(name).suffix}"
        if all(path.is_file() for path in pair) and pair[0].read_bytes() == pair[1].read_bytes():
            same[kind] += 1
        else:
            different[kind] += 1
            print(f"differs: {name}" if all(path.is_file() for path in pair) else f"in one only: {name}")
    print(f"{'file':24}{'same':>8}{'different':>12}")
    for kind in sorted({*same, *different}):
        print(f"{kind:24}{same[kind]:8}{different[kind]:12}")
    print(f"{'all':24}{same.total():8}{different.total():12}")
    sys.exit(bool(different))


if __name__ == "__main__":
    main()
