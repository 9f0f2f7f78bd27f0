"""All hostile cases, and those that are run quickly: a few of every kind."""

from __future__ import annotations

from tests.support.hostile import graphs, places, plans, problems, tables, targets

KINDS = (problems.CASES, tables.CASES, targets.CASES, graphs.CASES, plans.CASES, places.CASES)
CASES = tuple(case for cases in KINDS for case in cases)
QUICK = tuple(case for cases in KINDS for case in cases[:4])
