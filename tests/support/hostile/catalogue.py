"""All hostile cases."""

from __future__ import annotations

from tests.support.hostile import graphs, places, plans, problems, tables, targets

CASES = tuple(case for module in (problems, tables, targets, graphs, plans, places) for case in module.CASES)
