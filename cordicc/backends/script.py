"""The script that runs the plan beside it."""

from __future__ import annotations

from cordicc.backends.escaping import clean
from cordicc.plan.model import Plan

_TEMPLATE = '''\
#!/usr/bin/env python3
"""Simulate the plan in plan.json beside this file.

Takes the options of `cordicc simulate`, for example --random 1000 or --inputs in.csv --outputs out.csv.
"""

# Plan: {name}
import sys
from pathlib import Path

from cordicc.cli import main

if __name__ == "__main__":
    plan = Path(__file__).resolve().with_name("plan.json")
    sys.exit(main(["simulate", str(plan), *sys.argv[1:]]))
'''


def render(plan: Plan) -> str:
    """Return the text of `simulate.py`."""
    return text_for(plan.name)


def text_for(name: str) -> str:
    """Return the text of the script for the plan of a name."""
    return _TEMPLATE.format(name=clean(name))
