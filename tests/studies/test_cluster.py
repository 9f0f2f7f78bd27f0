"""The search on a Dask cluster: same result as here, and a diagnostic where there is no cluster."""

import importlib.util
import os
import sys
from fractions import Fraction

import pytest
from click.testing import Result

from cordicc.studies import cluster, sequence_search
from tests.support.command_line import run
from tests.support.selection import slow

INSTALLED = all(importlib.util.find_spec(name) for name in ("joblib", "distributed"))
needs_dask = pytest.mark.skipif(not INSTALLED, reason="needs joblib and distributed: cordicc[cluster]")
SMALL = ["--search", "--final-shift", "6", "--max-iterations", "10", "--scaling-error", "2**-8"]


def invoke(*arguments: str) -> Result:
    return run("sequences", *arguments)


@needs_dask
@pytest.mark.filterwarnings("ignore")  # those of Dask itself
@pytest.mark.parametrize("cores", [slow(1), 2])
def test_a_cluster_finds_what_one_process_finds(cores):
    from distributed import LocalCluster

    options = {"threads_per_worker": cores, "processes": False, "dashboard_address": None}
    with LocalCluster(n_workers=1, **options) as local:
        address = local.scheduler_address
        assert invoke(*SMALL, "--cluster", address).stdout == invoke(*SMALL, "--jobs", "1").stdout
        wanted = sequence_search.Conditions(8, Fraction(3), Fraction(1, 2**10), 12)
        parts = sequence_search.tasks(wanted, 1)
        assert list(cluster.outcomes(parts, address)) == list(sequence_search.outcomes(parts, 1))


@needs_dask
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_without_workers(monkeypatch):
    from distributed import LocalCluster

    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    with LocalCluster(n_workers=0, processes=False, dashboard_address=None) as local:
        result = invoke(*SMALL, "--cluster", local.scheduler_address)
    assert result.exit_code == 2
    assert "E721" in result.stderr
    assert "no workers" in result.stderr


@needs_dask
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("cores", [slow(1), 2])
def test_the_parts_run_on_the_workers(monkeypatch, cores):
    from distributed import LocalCluster

    here = os.getpid()
    monkeypatch.setattr(cluster, "run_all", lambda parts: [os.getpid()] * len(parts))
    options = {"threads_per_worker": cores, "dashboard_address": None}
    with LocalCluster(n_workers=1, processes=True, **options) as local:
        parts = sequence_search.tasks(sequence_search.Conditions(8, Fraction(3), Fraction(1, 2**10), 12), 1)[
            :40
        ]
        found = set(cluster.outcomes(parts, local.scheduler_address))
    assert len(found) == 1
    assert here not in found


@needs_dask
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x", "", "127.0.0.1:port"])
def test_no_scheduler_answers(monkeypatch, address):
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    result = invoke(*SMALL, "--cluster", address)
    assert result.exit_code == 2
    assert f"error[E721]: no Dask scheduler answers at {address}" in result.stderr
    assert "hint: give the address" in result.stderr


@pytest.mark.parametrize("missing", ["joblib", "distributed"])
def test_without_the_optional_packages(monkeypatch, missing):
    monkeypatch.setitem(sys.modules, missing, None)
    result = invoke(*SMALL, "--cluster", "tcp://127.0.0.1:8786")
    assert result.exit_code == 2
    assert "error[E721]: --cluster needs joblib and distributed" in result.stderr
    assert "pip install 'cordicc[cluster]'" in result.stderr


def test_jobs_and_cluster_exclude_each_other():
    result = invoke(*SMALL, "--jobs", "2", "--cluster", "tcp://127.0.0.1:8786")
    assert result.exit_code == 2
    assert "exclude each other" in result.stderr
