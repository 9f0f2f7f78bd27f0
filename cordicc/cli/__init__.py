"""The command line: one command a file, `main` gathers them, `arguments` says what several take."""

from cordicc.cli.main import main

__all__ = ["main"]
