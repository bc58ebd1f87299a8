"""hsr-sim and hsr-urdf know arms that bend in space."""

import json

import numpy as np
import pytest

from hsr_pin.cli import sim, urdf
from hsr_pin.cli.command import run
from hsr_pin.robot.urdf import load_urdf

QUICK = ["--bending", "space", "--links", "3", "--duration", "0.5"]


@pytest.fixture
def answered(capsys):
    """``answered(...)``: the exit code of hsr-sim, what it prints and what it says."""

    def call(*arguments, command=sim.command):
        code = run(command, list(map(str, arguments)))
        return code, *capsys.readouterr()

    return call


def test_a_torque_bends_the_arm_towards_its_direction(answered):
    code, out, _ = answered(*QUICK, "--mount", "upright", "--torque", 0.5, "--direction", 0.9, "--json")
    (record,) = json.loads(out)["runs"]
    assert code == 0
    assert np.arctan2(record["tip"]["y"], record["tip"]["x"]) == pytest.approx(0.9)
    assert record["direction"] == pytest.approx(0.9)
    assert record["arm"]["torsion"] is None
    assert record["off_plane"] < 1e-6


def test_the_tip_in_space_is_that_of_the_plane_turned(answered):
    plane = json.loads(answered("--links", 3, "--duration", 0.5, "--torque", 0.5, "--json")[1])["runs"][0]
    space = json.loads(answered(*QUICK, "--torque", 0.5, "--direction", 0.9, "--json")[1])["runs"][0]
    assert np.hypot(space["tip"]["x"], space["tip"]["y"]) == pytest.approx(plane["tip"]["x"], abs=1e-6)
    for name in ("settling_time", "overshoot"):
        assert space[name] == pytest.approx(plane[name], rel=1e-3)


def test_a_file_gives_two_components(answered, tmp_path):
    path = tmp_path / "commands.csv"
    path.write_text("t,tau_x,tau_y\n0,0,0\n0.1,0.4,0\n0.3,0.4,0.4\n0.5,0.4,0.4\n")
    code, out, _ = answered("--bending", "space", "--torsion", 0.5, "--mount", "upright", "--input", path, "--json")
    (record,) = json.loads(out)["runs"]
    assert code == 0
    assert record["torque"] == pytest.approx(0.4 * np.sqrt(2))
    assert record["off_plane"] > 1e-4


def test_the_table_tells_of_space(answered):
    code, out, _ = answered(*QUICK, "--torque", 0.5)
    assert code == 0
    assert "in space" in out and "towards" in out and "tip y" in out and "plane" in out


def test_pictures_and_pages_are_drawn(answered, tmp_path):
    picture, page = tmp_path / "tip.svg", tmp_path / "arm.html"
    code, _, _ = answered(*QUICK, "--torque", 0.5, "--direction", 1, "--plot", picture, "--html", page)
    assert code == 0
    assert picture.stat().st_size > 10_000 and page.stat().st_size > 100_000


def test_a_urdf_of_it_is_read_back(answered, tmp_path):
    path = tmp_path / "arm.urdf"
    code, _, _ = answered("--bending", "space", "--torsion", "0.4", "--cross-tilt", "0.2", "-o", path, command=urdf.command)
    arm = load_urdf(path)
    assert code == 0
    assert (arm.bending, arm.torsion, arm.cross_tilt) == ("space", 0.4, 0.2)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--direction", "1", "--torque", "0.5"], "--direction: expected one torque for an arm in space, got an arm in a plane"),
        (["--torsion", "1", "--torque", "0.5"], "torsion: expected none where the arm bends in a plane, got 1.0"),
        (["--cross-tilt", "1", "--torque", "0.5"], "cross_tilt: expected none where the arm bends in a plane, got 1.0"),
        (["--bending", "round"], "bending: expected plane or space, got 'round'"),
        ([*QUICK, "--torsion", "-1"], "torsion: expected a number, zero or more [Nm/rad], up to 1e+09, or infinity, got -1.0"),
        ([*QUICK, "--torque", "0.5", "--direction", "nan"], "direction: expected a finite angle [rad], got nan"),
        ([*QUICK, "--torque", "0.5", "--dynamics", "aba"], "dynamics: expected compiled or rnea for an arm in space, got 'aba'"),
        (
            [*QUICK, "--torque", "1", "--effect", "torque_map:quadratic=0.1,parity=even"],
            "laws that are defined for arms in space",
        ),
    ],
)
def test_what_cannot_be_is_said_in_one_line(answered, arguments, said):
    code, out, err = answered(*arguments)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_two_components_are_not_for_the_plane(answered, tmp_path):
    path = tmp_path / "commands.csv"
    path.write_text("t,tau_x,tau_y\n0,0,0\n0.1,0.4,0\n")
    assert answered("--input", path)[0] == 2
    assert "--direction" in answered("--bending", "space", "--direction", 1, "--input", path)[2]
