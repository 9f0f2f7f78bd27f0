"""Plans that tests share: each is compiled once a run, whatever the number of tests and workers.

A plan is kept as a file of the run's folder, under a key of all that it depends on: the problem, the files
that it names, the target, the options and the source of the package.  Who comes first compiles, and others
wait for it.  What tests change of a plan they change in a copy (`dataclasses.replace`).
"""

from __future__ import annotations

import fcntl
import os
import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import cordicc
from cordicc.pipeline import Compiled, Options, judged, plan_file
from cordicc.plan.model import Plan as PlanData
from cordicc.schedule.place import place
from cordicc.schedule.request import Limits
from tests.support.paths import PACKAGE

FOLDER = "CORDICC_TEST_PLANS"
"""The environment variable of the folder.  A run makes one and removes it; who sets it keeps the plans."""

_seen: dict[str, cordicc.Plan] = {}


def compiled(path: Path, **options: Any) -> cordicc.Plan:
    """Return what `cordicc.compile` makes of a problem file; `options` are the same."""
    asked = _request(**options)
    return _kept(
        "compiled", path, asked, lambda: judged(Compiled(_chosen(path, asked), ()), asked.certify).plan
    )


def planned(path: Path, *, ii: int = 1, **options: Any) -> cordicc.Plan:
    """Return a plan without accuracy figures.

    For another interval the operations that were chosen for interval 1 are only placed anew, on which they
    are seldom the cheapest.
    """
    first = _chosen(path, _request(**options))
    if ii == 1:
        return first
    asked = _request(ii=ii, **options)
    limits = replace(asked.limits, effort=asked.limits.effort.times(asked.effort))
    again = replace(first, options=replace(first.options, ii=ii))
    return _kept("placed", path, asked, lambda: place(again, limits))


def _request(
    *,
    target: str = "kinematic",
    units: str = "auto",
    minimize: str = "processors",
    ii: int = 1,
    certify: bool | None = None,
    copies: int = 1,
    effort: float = 1.0,
) -> Options:
    return Options(target, units, Limits(minimize, ii), certify, copies, effort)


def _chosen(path: Path, asked: Options) -> cordicc.Plan:
    """Return the plan of a file before it is run."""
    return _kept("planned", path, asked, lambda: plan_file(path, asked).plan)


def _kept(kind: str, path: Path, asked: Options, make: Callable[[], PlanData]) -> cordicc.Plan:
    """Return the plan of a key, from memory, from the folder, or made."""
    key = _key(kind, path, asked)
    if key not in _seen:
        folder = os.environ.get(FOLDER)
        _seen[key] = cordicc.Plan.of(make()) if folder is None else _in_folder(Path(folder) / key, make)
    return _seen[key]


def _in_folder(file: Path, make: Callable[[], PlanData]) -> cordicc.Plan:
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if file.exists():
            kept: cordicc.Plan = pickle.loads(file.read_bytes())
            return kept
        made = cordicc.Plan.of(make())
        part = file.with_suffix(".part")
        part.write_bytes(pickle.dumps(made))
        part.replace(file)
        return made


def _key(kind: str, path: Path, asked: Options) -> str:
    text = path.read_text(encoding="utf-8")
    named = [other.read_bytes() for other in sorted(path.parent.iterdir()) if other.name in text]
    own_target = Path(asked.target).read_bytes() if Path(asked.target).is_file() else b""
    parts = (_source(), kind, path.name, text, named, repr(asked), own_target)
    return sha256(repr(parts).encode()).hexdigest()[:32]


@cache
def _source() -> str:
    """Return a hash of the package, its targets and templates included."""
    files = sorted(p for p in PACKAGE.rglob("*") if p.is_file() and p.suffix != ".pyc")
    return sha256(b"\0".join(p.read_bytes() for p in files)).hexdigest()
