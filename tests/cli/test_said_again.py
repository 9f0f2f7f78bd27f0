"""What the command line says again: what is slow to import, and files named in a text."""

import re

import click
import pytest

from cordicc.artefacts import ARTEFACTS, Written
from cordicc.backends.pictures.diagram import PAGE_WIDTH
from cordicc.cli import compile, draw, explore
from cordicc.targets.target import DEFAULT_TARGET


def default(command: click.Command, name: str) -> object:
    (option,) = (each for each in command.params if each.name == name)
    return option.default


@pytest.mark.parametrize("command", [compile.command, explore.command])
def test_the_target_is_the_usual_one(command):
    assert default(command, "target") == DEFAULT_TARGET


def test_a_picture_is_as_wide_as_a_page():
    assert default(draw.command, "width") == PAGE_WIDTH


def test_compile_names_the_files_that_it_always_writes():
    said = re.findall(r"[a-z]+\.[a-z]+", (compile.command.help or "").split("\b")[0].partition("gets")[2])
    written = [each.file for each in ARTEFACTS.values() if each.written is Written.ALWAYS]
    assert said == written
