"""Run the command line as `python -m cordicc`."""

from cordicc.cli.main import main

main(prog_name="cordicc")
