"""`hsr-urdf` writes the arm that its options describe, or says in one line why not."""

import re
import subprocess
import sys

import pytest

from hsr_pin.cli.arm import ARM_OPTIONS
from hsr_pin.cli.command import run
from hsr_pin.cli.urdf import command
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf, load_urdf, urdf_to_arm

PROGRAM = "import sys; from hsr_pin.cli.urdf import main; main()"


def test_the_papers_arm_goes_to_standard_output(capsys):
    assert run(command, ["--links", "4"]) == 0
    out, err = capsys.readouterr()
    assert (out, err) == (arm_to_urdf(ArmSpecification()), "")


def test_every_option_reaches_the_file(tmp_path):
    path = tmp_path / "arm.urdf"
    options = "--links 7 --keq 2 --damping 0.07 --placement mid --mount upright --length 0.3 --mass 0.2 --diameter 0.05"
    assert run(command, [*options.split(), "--tip-mass", "0.01", "--tilt", "-0.1", "-o", str(path)]) == 0
    assert load_urdf(path) == ArmSpecification(7, 2.0, 0.07, "mid", "upright", 0.3, 0.2, 0.05, 0.01, -0.1)


def test_damping_follows_the_stiffness_as_in_the_paper(capsys):
    assert run(command, ["--keq", "2.33"]) == 0
    assert urdf_to_arm(capsys.readouterr().out).damping == pytest.approx(0.1)


def test_the_help_names_the_defaults_of_the_specification(capsys):
    assert run(command, ["--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    for name, (_, _, default) in ARM_OPTIONS.items():
        assert name in ("damping", "links", "placement") or default == getattr(ArmSpecification, name)
        assert re.search(rf"--{name.replace('_', '-')} .*?\[default: {re.escape(str(default))}\]", shown)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--links", "0"], "links: expected a whole number from 1 to 1000, got 0"),
        (["--links", "2.5"], "links: expected a whole number from 1 to 1000, got '2.5'"),
        (["--links", "True"], "links: expected a whole number from 1 to 1000, got 'True'"),
        (["--links", "nan"], "links: expected a whole number from 1 to 1000, got 'nan'"),
        (["--keq", "-1"], "keq: expected a number, more than zero [Nm/rad], got -1.0"),
        (["--keq", "nan"], "keq: expected a number, more than zero [Nm/rad], got nan"),
        (["--keq", "1" * 400], "keq: expected a number, more than zero [Nm/rad], got inf"),
        (["--damping", "some"], "damping: expected a number, zero or more [Nm s/rad], got 'some'"),
        (["--tip-mass", "-0.1"], "tip_mass: expected a number, zero or more [kg], got -0.1"),
        (["--tilt", "9"], "tilt: expected an angle from -pi to pi rad, got 9.0"),
        (["--mount", "sideways"], "mount: expected hanging or upright or horizontal or flat, got 'sideways'"),
        (["--placement", "end"], "placement: expected base or mid or shifted, got 'end'"),
        (["--frobnicate"], "--frobnicate"),
        (["--links"], "'--links' requires an argument"),
        (["extra"], "unexpected extra argument (extra)"),
    ],
)
def test_bad_input_is_one_line_exit_code_two_and_no_file(capsys, tmp_path, arguments, said):
    assert run(command, ["-o", str(tmp_path / "arm.urdf"), *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hsr-urdf: error: ")
    assert said in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_written_is_one_line_and_leaves_nothing(capsys, tmp_path):
    (tmp_path / "file").write_text("mine")
    assert run(command, ["-o", str(tmp_path / "file" / "arm.urdf")]) == 2
    err = capsys.readouterr().err
    assert re.fullmatch(r"hsr-urdf: error: .*arm\.urdf: cannot write the file: .*got Not a directory\n", err)
    assert (tmp_path / "file").read_text() == "mine"


def test_help_loads_nothing_heavy():
    heavy = "print(sorted({'numpy', 'pinocchio', 'jinja2', 'scipy', 'rich'} & set(sys.modules)), file=sys.stderr)"
    program = f"import sys, atexit; atexit.register(lambda: {heavy}); {PROGRAM}"
    done = subprocess.run([sys.executable, "-c", program, "--help"], capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n"


def test_the_program_ends_with_the_exit_code():
    done = subprocess.run([sys.executable, "-c", PROGRAM, "--links", "0"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "hsr-urdf: error: links: expected a whole number from 1 to 1000, got 0\n"
