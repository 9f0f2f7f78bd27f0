"""Run the command line as `python -m cordicc`."""

from cordicc.cli import main

main(prog_name="cordicc")
