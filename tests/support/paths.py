"""Where the files are that tests read."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "cordicc"
EXAMPLES = ROOT / "examples"
CORPUS = ROOT / "tests" / "whole" / "corpus"
