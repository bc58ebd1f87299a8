"""`hsr-export` writes the model for other simulators and says what is in it; bad input is one line and nothing is written."""

import json
import subprocess
import sys
from xml.etree import ElementTree

import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.export import command

PROGRAM = "import sys; from hsr_pin.cli.export import main; main()"
RESULT = {
    "schema": 1,
    "dataset": "made",
    "verdict": {"status": "identified", "effects": ["dry_friction"], "sentence": "dry_friction is missing from the model."},
    "candidates": [
        {
            "effects": ["dry_friction"],
            "options": {},
            "parameters": {"keq_scale": {"value": 1.1}, "dry_friction.level": {"value": 0.06}},
        }
    ],
    "arm": {
        "length": 0.24, "mass": 0.15, "diameter": 0.04, "mount": "hanging",
        "levels": [{"keq": 1.11, "damping": 0.05, "tip_mass": 0.0}, {"keq": 2.33, "damping": 0.1, "tip_mass": 0.0}],
        "markers": [{"name": "tip", "arc_length": 0.24}],
    },
}  # fmt: skip


@pytest.fixture
def result(tmp_path):
    path = tmp_path / "result.json"
    path.write_text(json.dumps(RESULT), encoding="utf-8")
    return str(path)


@pytest.mark.parametrize(("target", "root"), [("mjcf", "mujoco"), ("urdf", "robot"), ("sdf", "sdf")])
def test_every_target_is_written_and_reported(target, root, tmp_path, capsys):
    path = tmp_path / "arm.xml"
    assert run(command, ["--to", target, "-o", str(path), "--links", "5", "--effect", "torque_bias:bias=0.1"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith(f"wrote {path}\n")
    assert "torque_bias" in out
    assert ElementTree.parse(path).getroot().tag == root
    assert path.read_text(encoding="utf-8").count("joint_5") >= 1
    assert [file.name for file in tmp_path.iterdir()] == ["arm.xml"]


def test_a_module_is_written_where_one_is_needed(tmp_path, capsys):
    path = tmp_path / "arm.xml"
    assert run(command, ["--to", "mjcf", "-o", str(path), "--effect", "viscoelastic:ratio=0.3"]) == 0
    assert f"wrote {tmp_path / 'arm_laws.py'}" in capsys.readouterr().out
    compile((tmp_path / "arm_laws.py").read_text(encoding="utf-8"), "arm_laws.py", "exec")


def test_a_diagnosis_is_handed_on(result, tmp_path, capsys):
    path = tmp_path / "arm.xml"
    assert (
        run(command, ["--to", "mjcf", "-o", str(path), "--from", result, "--keq", "2.33", "--links", "6", "--mujoco", "3"]) == 0
    )
    text = path.read_text(encoding="utf-8")
    assert "a diagnosis of made: dry_friction is missing from the model." in text
    spring = ElementTree.fromstring(text.encode()).find(".//joint[@name='joint_6']").get("stiffness")
    assert float(spring) == pytest.approx(6 * 1.1 * 2.33)
    assert "beside it: dry_friction: law in arm_laws.py" in capsys.readouterr().out


@pytest.mark.parametrize("target", ["mjcf", "urdf", "sdf"])
def test_a_dataset_of_any_name_makes_whole_xml(target, tmp_path, capsys):
    odd = RESULT | {"dataset": "a--->b ]]> \x1b[31m<!---- -"}
    (tmp_path / "result.json").write_text(json.dumps(odd), encoding="utf-8")
    arguments = ["--to", target, "-o", str(tmp_path / "arm.xml"), "--from", str(tmp_path / "result.json"), "--keq", "1.11"]
    assert run(command, arguments) == 0
    assert all(line.isprintable() for line in capsys.readouterr().out.splitlines())
    ElementTree.parse(tmp_path / "arm.xml")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "Missing option '--to'"),
        (["--to", "usd"], "'usd' is not one of 'mjcf', 'urdf', 'sdf'"),
        (["--to", "sdf", "--links", "0"], "links: expected a whole number from 1 to 1000, got 0"),
        (["--to", "sdf", "--effect", "magic"], "effect: expected"),
        (
            ["--to", "sdf", "--effect", "torque_bias:bias=0.1", "--effect", "torque_bias:bias=0.2"],
            "effects: expected each effect at most once",
        ),
        (["--to", "sdf", "--dataset", "somewhere"], "--dataset: expected --from RESULT.json together with this option, got none"),
        (["--to", "sdf", "--from", "RESULT"], "--keq: expected one of the declared stiffnesses, 1.11 or 2.33 Nm/rad, got none"),
        (["--to", "sdf", "--from", "RESULT", "--mass", "0.2"], "--from: expected only --keq, --links, --placement, --mount"),
        (["--to", "sdf", "--from", "RESULT", "--effect", "torque_bias:bias=0.1"], "got --effect; the result determines the rest"),
        (["--to", "sdf", "--from", "nowhere.json"], "nowhere.json: cannot read the file"),
    ],
)
def test_bad_input_is_one_line_exit_code_two_and_no_file(arguments, said, result, tmp_path, capsys):
    given = [result if argument == "RESULT" else argument for argument in arguments]
    assert run(command, ["-o", str(tmp_path / "arm.xml"), *given]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hsr-export: error: ")
    assert said in err
    assert err.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["result.json"]


def test_a_file_that_cannot_be_written_is_one_line(tmp_path, capsys):
    assert run(command, ["--to", "urdf", "-o", str(tmp_path / "nowhere" / "arm.urdf")]) == 2
    assert "cannot write the file" in capsys.readouterr().err


def test_help_loads_nothing_heavy():
    heavy = "print(sorted({'numpy', 'pinocchio', 'jinja2', 'scipy', 'rich', 'mujoco'} & set(sys.modules)), file=sys.stderr)"
    program = f"import sys, atexit; atexit.register(lambda: {heavy}); {PROGRAM}"
    done = subprocess.run([sys.executable, "-c", program, "--help"], capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n"
