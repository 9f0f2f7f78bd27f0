"""The command line as tests run it: in this process."""

from click.testing import CliRunner, Result

from cordicc.cli import main


def run(*arguments: object) -> Result:
    """Run `cordicc` with arguments; what is no error of the command line is raised."""
    return CliRunner().invoke(main, [str(a) for a in arguments], catch_exceptions=False)
