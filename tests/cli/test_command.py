"""A command ends with its result, or with one line on stderr and exit code 2."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest

from hsr_pin.cli.command import run
from hsr_pin.errors import HsrError, InputError
from hsr_pin.recordings.write import write_dataset


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


def test_an_interrupt_that_a_module_turned_into_another_error_is_an_interrupt(capsys):
    error = RuntimeError("Error calling __set_name__")
    error.__cause__ = KeyboardInterrupt()
    assert run(command_that(error), []) == 130
    assert capsys.readouterr().err == "hsr-test: error: interrupted\n"


def test_a_long_name_in_any_error_is_cut(capsys):
    for error in (
        HsrError("x" * 9999),
        FileNotFoundError(2, "No such file", "x" * 9999),
        InputError("links", received="x" * 9999),
    ):
        assert run(command_that(error), []) == 2
        assert len(capsys.readouterr().err) < 300
    assert run(command_that(), ["--links", "x" * 9999]) == 2
    assert len(capsys.readouterr().err) < 400


@pytest.mark.parametrize(("program", "spared"), [("hsr-diagnose", True), ("laboratory.py", False)])
def test_a_command_spares_the_collector_and_a_program_that_imports_one_keeps_its_own(program, spared):
    code = "import gc, sys; usual = gc.get_threshold(); sys.argv.pop(0); import hsr_pin.cli; print(gc.get_threshold() != usual)"
    done = subprocess.run([sys.executable, "-c", code, program], capture_output=True, text=True, check=True, env=ENVIRONMENT)
    assert done.stdout.split() == [str(spared)]


#: As installers write it, but for the name of the interpreter.
SCRIPT = "import sys\nfrom hsr_pin.cli.sim import main\nif __name__ == '__main__':\n    sys.exit(main())\n"
ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="pipes, signals and streams are others on Windows")


@pytest.fixture
def script(tmp_path):
    """``hsr-sim`` as it is installed."""
    (tmp_path / "hsr-sim").write_text(SCRIPT)
    return [sys.executable, "hsr-sim", "--torque", "0.5", "--duration", "0.3"]


LEFT = """import atexit
atexit.register(print, "over")
class Held:
    def __del__(self):
        print("taken down")
held = Held()
"""


def test_a_command_ends_at_once_and_does_what_was_left_for_the_end(tmp_path):
    for name, words in (("hsr-sim", ["over"]), ("laboratory.py", ["over", "taken", "down"])):
        (tmp_path / name).write_text(LEFT + SCRIPT)
        done = subprocess.run(
            [sys.executable, name, "--links", "0"], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True
        )
        assert (done.returncode, done.stdout.split()) == (2, words)
        assert done.stderr.startswith("hsr-sim: error: ")


@POSIX
@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_are_no_fault_and_files_are_whole(script, tmp_path, closed):
    line = f"{' '.join(script)} --html run.html --plot run.png {closed}"
    done = subprocess.run(["sh", "-c", line], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    text = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE") and text.rstrip().endswith("</html>")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


@POSIX
def test_a_reader_that_has_seen_enough_does_not_cost_the_files(script, tmp_path):
    line = f"{' '.join(script)} --html run.html | head -c 1; sleep 2"
    done = subprocess.run(["sh", "-c", line], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("1", "")  # the first digit of "16 links"
    assert (tmp_path / "run.html").exists()


@POSIX
def test_a_full_disk_behind_standard_output_is_one_line(script, tmp_path):
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    done = subprocess.run(
        ["sh", "-c", f"{' '.join(script)} > /dev/full"], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "No space left" in done.stderr


def test_an_output_that_lacks_a_sign_gets_its_escape():
    program = (
        "import click, sys; from hsr_pin.cli.command import run\n"
        "sys.exit(run(click.Command('hsr-test', callback=lambda: click.echo('more\\u2026')), []))"
    )
    environment = ENVIRONMENT | {"PYTHONIOENCODING": "latin-1"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "more\\u2026\n", "")


@POSIX
def test_ctrl_c_while_a_command_is_loaded_leaves_no_traceback(script, tmp_path):
    """From the moment at which the command's first module is there: before, it is Python that starts."""
    (tmp_path / "sitecustomize.py").write_text("import builtins, os, sys\n" + WAITING)
    environment = ENVIRONMENT | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ENVIRONMENT['PYTHONPATH']}"}
    for delay in (0.0, 0.01, 0.03, 0.06, 0.1, 0.2):
        process = subprocess.Popen(
            script, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
        )
        assert process.stderr.readline() == "loading\n"
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        assert errors in ("", "hsr-sim: error: interrupted\n"), delay
        assert process.returncode in (0, 130, -signal.SIGINT)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 128 + signal.SIGTERM)])
def test_a_signal_that_comes_while_python_calls_back_is_not_lost(number, code):
    """Python drops what is raised there, and says "Exception ignored in" (seen where a lock of its imports was freed)."""
    program = (
        "import click, signal, sys, time, weakref; from hsr_pin.cli.command import run\n"
        "class Thing: pass\n"
        "def wait():\n"
        "    thing = Thing()\n"
        f"    gone = weakref.ref(thing, lambda _: signal.raise_signal({int(number)}))\n"
        "    del thing\n"
        "    time.sleep(30)\n"
        "signal.signal(signal.SIGINT, signal.SIG_DFL)\n"
        "sys.exit(run(click.Command('hsr-test', callback=wait), []))"
    )
    done = subprocess.run([sys.executable, "-c", program], env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (code, "")
    assert done.stderr == ("hsr-test: error: interrupted\n" if number == signal.SIGINT else "")


@POSIX
def test_a_command_that_is_told_to_end_ends_its_workers_first_and_says_nothing(heavy_tip, tmp_path):
    write_dataset(heavy_tip, tmp_path / "data")
    (tmp_path / "hsr-diagnose").write_text(SCRIPT.replace("sim", "diagnose"))
    arguments = ["data", "--links", "2", "--effects", "tip_mass,dry_friction", "--jobs", "2"]
    told = "import multiprocessing, os\n" + BEGUN
    (tmp_path / "sitecustomize.py").write_text(told)
    environment = ENVIRONMENT | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ENVIRONMENT['PYTHONPATH']}"}
    process = subprocess.Popen(
        [sys.executable, "hsr-diagnose", *arguments],
        cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1,
    )  # fmt: skip
    assert process.stderr.readline() == "begun\n"
    process.terminate()
    out, errors = process.communicate(timeout=60)  # semaphores that are left behind would be told here, after the end
    assert (process.returncode, out, errors) == (128 + signal.SIGTERM, "", "")


#: Says when the first worker process is begun.
BEGUN = """
import multiprocessing.process
real = multiprocessing.process.BaseProcess.start
def told(process):
    real(process)
    multiprocessing.process.BaseProcess.start = real
    os.write(2, b"begun\\n")
multiprocessing.process.BaseProcess.start = told
"""
#: Says when `click`, the first thing that a command loads, is asked for.
WAITING = """
real = builtins.__import__
def told(name, *rest):
    if name == "click" and builtins.__import__ is told:
        builtins.__import__ = real
        os.write(2, b"loading\\n")
    return real(name, *rest)
builtins.__import__ = told
"""


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


def test_options_are_listed_in_groups_and_each_once(capsys):
    from hsr_pin.cli.diagnose import command as diagnose

    assert run(diagnose, ["--help"]) == 0
    shown = capsys.readouterr().out
    titles = [line for line in shown.splitlines() if line.endswith(":") and not line.startswith(" ")]
    assert titles == ["Options:", "Trials:", "Model:", "Output:", "Computation:"]
    options = [parameter.opts[0] for parameter in diagnose.params if parameter.opts[0].startswith("--")]
    assert [shown.count(f"\n  {name} ") for name in options] == [1] * len(options)
