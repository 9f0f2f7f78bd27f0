"""The search on an existing Dask cluster, through joblib's Dask backend; both are imported only here.

They are the optional dependencies `cordicc[cluster]`.  The scheduler and the workers
need cordicc itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from importlib import import_module
from typing import Any

from cordicc.base.diagnostics import Diagnostic, InvalidInput
from cordicc.studies.sequence_search import Outcome, SearchTask, run

_PARTS = 16
"""Parts that travel together: some milliseconds of work each, as a task of its own costs one."""

CONNECT_SECONDS = 10


def outcomes(parts: Sequence[SearchTask], address: str) -> Iterator[Outcome]:
    """Run the parts on the cluster of a scheduler and yield what they find, in the order of the parts.

    Raises:
        InvalidInput: joblib or distributed is not installed, nobody answers at the address, it has
            no workers, or they cannot run the search.
    """
    try:
        joblib, distributed = import_module("joblib"), import_module("distributed")
    except ImportError as error:
        hint = "pip install 'cordicc[cluster]', or leave out --cluster"
        raise _invalid(f"--cluster needs joblib and distributed: {error}", hint) from error
    bundles = [parts[i : i + _PARTS] for i in range(0, len(parts), _PARTS)]
    with _client(distributed, address) as client:
        _try_out(client, address)
        for bundle in _results(joblib, client, bundles):
            yield from bundle


def executor(address: str) -> Executor:
    """Return what runs functions of cordicc on the cluster of a scheduler.

    Raises:
        InvalidInput: distributed is not installed, nobody answers at the address, or it has no workers.
    """
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        hint = "pip install 'cordicc[cluster]', or leave out --cluster"
        raise _invalid(f"--cluster needs distributed: {error}", hint) from error
    client = _client(distributed, address)
    try:
        client.wait_for_workers(1, timeout=CONNECT_SECONDS)
    except TimeoutError as error:
        client.close()
        raise _no_workers(address) from error
    found: Executor = client.get_executor()
    return found


def _no_workers(address: str) -> InvalidInput:
    return _invalid(f"the cluster at {address} has no workers", f"start one: dask worker {address}")


def _try_out(client: Any, address: str) -> None:
    """Send nothing to everybody: joblib would wait for ever if the search could not be unpacked."""
    try:
        client.wait_for_workers(1, timeout=CONNECT_SECONDS)
        client.run(run_all, [])
        client.submit(run_all, []).result()
    except TimeoutError as error:
        raise _no_workers(address) from error
    except Exception as error:  # of what class depends on who could not unpack it
        hint = "install the same cordicc for the scheduler and for every worker"
        raise _invalid(f"the cluster at {address} cannot import the search", hint) from error


def _results(joblib: Any, client: Any, bundles: Sequence[Sequence[SearchTask]]) -> Iterator[list[Outcome]]:
    if sum(client.ncores().values()) == 1:  # joblib would not send anything to a single core
        for future in client.map(run_all, bundles):
            yield future.result()
        return
    with joblib.parallel_config(backend="dask", client=client):
        parallel = joblib.Parallel(return_as="generator", batch_size=1)
        yield from parallel(joblib.delayed(run_all)(bundle) for bundle in bundles)


def run_all(parts: Sequence[SearchTask]) -> list[Outcome]:
    """Search some parts: what a worker is sent."""
    return [run(part) for part in parts]


def _client(distributed: Any, address: str) -> Any:
    """Return a client of the scheduler, to be closed by its context."""
    try:
        return distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        hint = "give the address that `dask scheduler` prints, such as tcp://host:8786"
        raise _invalid(f"no Dask scheduler answers at {address}", hint) from error


def _invalid(message: str, hint: str) -> InvalidInput:
    return InvalidInput([Diagnostic("E721", message, hint=hint)])
