"""Runs the command line in a process of its own, with limits, and tells how it ended.

The processes are forked from one that has imported everything, so that a case costs what it does and
little more.  Limits of address space and processor time are a safety net: a case that reaches one fails.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import resource
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

ADDRESS_SPACE = 6 << 30
"""Bytes; libraries reserve far more than they use."""

CPU_SECONDS = 120

_PRELOADED = [
    "cordicc.cli.main",
    "cordicc.pipeline",
    "cordicc.api",
    "cordicc.cli.sample_run",
    "tests.whole.hostile.running",
]
_CONTEXT = multiprocessing.get_context("forkserver")
_CONTEXT.set_forkserver_preload(_PRELOADED)


@dataclass(frozen=True)
class Outcome:
    """How a run ended: its status (negative: killed by a signal), what it wrote, what it took."""

    status: int
    stdout: str
    stderr: str
    cpu_seconds: float
    peak_bytes: int

    @property
    def codes(self) -> list[str]:
        """The codes of the errors that were told."""
        return re.findall(r"error\[([A-Z]\d+)\]", self.stderr)

    @property
    def crashed(self) -> bool:
        """Whether it ended otherwise than a command may."""
        return self.status not in (0, 1, 2) or "Traceback" in self.stderr + self.stdout


def run(arguments: Sequence[str], folder: Path, cpu_seconds: int = CPU_SECONDS) -> Outcome:
    """Run `cordicc` with arguments in a folder."""
    record = folder / ".outcome"
    record.mkdir(exist_ok=True)
    process = _CONTEXT.Process(target=_run, args=(list(arguments), str(folder), str(record), cpu_seconds))
    process.start()
    process.join(10 * cpu_seconds)
    if process.exitcode is None:
        process.kill()
        process.join()
    assert process.exitcode is not None
    texts = {}
    for name in ("stdout", "stderr", "used"):
        file = record / name
        texts[name] = file.read_bytes().decode("utf-8", "replace") if file.exists() else ""
    used = json.loads(texts["used"] or '{"cpu": 0, "peak": 0}')
    return Outcome(process.exitcode, texts["stdout"], texts["stderr"], used["cpu"], used["peak"])


def _run(arguments: list[str], folder: str, record: str, cpu_seconds: int) -> None:
    os.chdir(folder)
    for name, number in (("stdout", 1), ("stderr", 2)):
        file = os.open(f"{record}/{name}", os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
        os.dup2(file, number)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    before = resource.getrusage(resource.RUSAGE_SELF)
    start = before.ru_utime + before.ru_stime
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CPU, (int(start) + cpu_seconds, int(start) + cpu_seconds + 5))
    status = 3
    try:
        from cordicc.cli import main

        main(arguments, prog_name="cordicc")
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        used = resource.getrusage(resource.RUSAGE_SELF)
        figures = {"cpu": used.ru_utime + used.ru_stime - start, "peak": used.ru_maxrss * 1024}
        Path(record, "used").write_text(json.dumps(figures))
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(status)
