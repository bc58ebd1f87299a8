"""``hsr``: the other commands under one name."""

import importlib
from importlib.metadata import version

import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.umbrella import COMMANDS, command


def test_its_help_lists_every_command_and_its_version_is_the_packages(capsys):
    assert run(command, ["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(f"  {name} " in shown for name in COMMANDS)
    assert run(command, ["--version"]) == 0
    assert version("hsr_pin") in capsys.readouterr().out


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_is_the_one_that_has_a_name_of_its_own(name, capsys):
    assert run(command, [name, "--help"]) == 0
    own = importlib.import_module(f"hsr_pin.cli.{COMMANDS[name][0]}").command
    assert own.name == f"hsr-{name}"
    assert own.help.strip().splitlines()[0].split()[0] in capsys.readouterr().out


def test_an_unknown_command_is_one_line(capsys):
    assert run(command, ["diagnos"]) == 2
    assert capsys.readouterr().err == "hsr: error: No such command 'diagnos'.\n"
