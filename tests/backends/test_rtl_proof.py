"""The stream around a core, proven by induction: none lost, none doubled, the payload stable, whatever waits.

The proof is that of the package, `make formal`: of the wrapper and of the valid bits of the core as they are
generated, for any words that leave the core and every behaviour of both sides.
"""

import subprocess
from pathlib import Path

import pytest

from tests.support.hardware import changed, made, needs, written
from tests.support.plans import compiled
from tests.support.selection import quick

PROBLEMS = {
    "sum": "inputs: {x: [0, 1]}\nequations:\n  - y = x + 0.5\n",
    "product": "inputs: {x: [0, 1]}\nequations:\n  - y = x*x\n",
    "both": "inputs: {x: [0, 1]}\nequations:\n  - y = x*x + 0.3*x\n",
}
FAULTS = {
    "a credit too many": ("credits <= DEPTH;", "credits <= DEPTH + 1;"),
    "no bypass": ("is_kept ? kept_word : read_word", "read_word"),
    "tlast of another sample": ("lasts[entry] <= s_axis_tlast", "lasts[tail] <= s_axis_tlast"),
    "the next word too early": ("head_now = taken ? head_next : head", "head_now = head_next"),
    "a credit lost": ("if (taken && !accepted) credits", "if (taken && !accepted && made) credits"),
}


def package(folder: Path, problem: str, interval: int = 1, reset: str = "rst") -> Path:
    (folder / "problem.yaml").write_text(problem, encoding="utf-8")
    plan = compiled(folder / "problem.yaml", target="fixed24", ii=interval, certify=False, effort=0.05)
    return written(plan, folder, 1, reset)


def proven(folder: Path) -> bool:
    """Tell whether yosys proves the wrapper of a package."""
    end = made(folder, "formal")
    assert "PROVEN" in end.stdout or "proof did fail" in end.stdout + end.stderr, end.stdout + end.stderr
    return end.returncode == 0


@needs("yosys")
@pytest.mark.parametrize("problem", quick(PROBLEMS, "sum"))
@pytest.mark.parametrize(("interval", "reset"), quick([(1, "rst"), (2, "arst_n"), (3, "rst")], (2, "arst_n")))
def test_the_stream_keeps_every_sample(problem: str, interval: int, reset: str, tmp_path: Path) -> None:
    assert proven(package(tmp_path, PROBLEMS[problem], interval, reset))


@needs("yosys")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_not_proven(fault: str, tmp_path: Path) -> None:
    folder = package(tmp_path, PROBLEMS["sum"])
    changed(folder, "problem_axis.v", *FAULTS[fault])
    assert not proven(folder)


@needs("yosys")
@pytest.mark.parametrize("interval", [1, 3])
def test_the_valid_bits_of_the_core_are_in_the_proof(interval: int, tmp_path: Path) -> None:
    folder = package(tmp_path, PROBLEMS["both"], interval)
    changed(folder, "problem_core.v", ", in_valid}", ", 1'b1}")
    assert not proven(folder)


@needs("yosys", "sby")
def test_symbiyosys_proves_it_too(tmp_path: Path) -> None:
    folder = package(tmp_path, PROBLEMS["sum"])
    end = subprocess.run(
        ["sby", "-f", "formal/problem_axis.sby"], cwd=folder, capture_output=True, text=True, timeout=600
    )
    assert end.returncode == 0, end.stdout + end.stderr
