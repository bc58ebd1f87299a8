"""A command ends with its result, or with one line on stderr and exit code 2."""

import os
import subprocess
import sys
from pathlib import Path

import click
import pytest

from hsr_pin.cli.command import run
from hsr_pin.errors import HsrError, InputError


def command_that(raises=None, returns=None):
    @click.command(name="hsr-test")
    @click.option("--links", type=int)
    def command(links):
        if raises is not None:
            raise raises
        return returns

    return command


def test_success_is_exit_code_zero():
    assert run(command_that(), []) == 0


def test_help_is_exit_code_zero(capsys):
    assert run(command_that(), ["--help"]) == 0
    assert "--links" in capsys.readouterr().out


def test_an_exit_code_returned_by_the_command_is_kept():
    assert run(command_that(returns=1), []) == 1


@pytest.mark.parametrize(
    ("raised", "arguments", "said"),
    [
        (
            InputError("links", expected="a number", received="x", file="a.toml", line=3),
            [],
            "a.toml:3: links: expected a number, got x",
        ),
        (HsrError("two\n  lines"), [], "two lines"),
        (FileNotFoundError(2, "No such file or directory", "gone.csv"), [], "gone.csv: No such file or directory"),
        (None, ["--links", "many"], "'many' is not a valid integer"),
        (None, ["--linsk", "4"], "--links"),
    ],
)
def test_bad_input_is_one_line_on_stderr_and_exit_code_two(capsys, raised, arguments, said):
    assert run(command_that(raised), arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("hsr-test: error: ")
    assert said in err


def test_an_interrupt_is_exit_code_130(capsys):
    assert run(command_that(KeyboardInterrupt()), []) == 130
    assert capsys.readouterr().err == "hsr-test: error: interrupted\n"


def test_a_fault_of_ours_is_not_hidden():
    with pytest.raises(ZeroDivisionError):
        run(command_that(ZeroDivisionError()), [])


@pytest.mark.skipif(sys.platform == "win32", reason="pipes end differently on Windows")
def test_a_reader_that_has_seen_enough_ends_the_command_quietly():
    program = (
        "import click, sys; from hsr_pin.cli.command import run\n"
        "command = click.Command('hsr-test', callback=lambda: [click.echo('x' * 80) for _ in range(100000)] and None)\n"
        "sys.exit(run(command, []))"
    )
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
    assert process.stdout is not None
    process.stdout.readline()
    process.stdout.close()
    errors = process.stderr.read() if process.stderr else b""
    process.stderr.close()
    assert process.wait() == 0
    assert errors == b""
