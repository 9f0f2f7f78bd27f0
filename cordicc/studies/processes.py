"""Processes that a study works in: they end with the one that started them, however that ends."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context, parent_process


def process_pool(count: int, load: Callable[[], None] | None = None) -> ProcessPoolExecutor:
    """Return a pool of so many processes, each of which begins with `load`."""
    return ProcessPoolExecutor(count, get_context("spawn"), _begin, (load,))


def _begin(load: Callable[[], None] | None) -> None:
    # A worker waits for work, and would do so for ever after its parent was killed.
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if load is not None:
        load()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
