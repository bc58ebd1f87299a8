"""Recordings of a robot are read, or refused in one line that says where the fault is."""

import shutil

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.recordings.samples import ROBOTS, robot_folder
from hsr_pin.robots import read_robot
from hsr_pin.robots.model import RobotModel


@pytest.fixture
def folder(tmp_path):
    shutil.copytree(robot_folder("double-pendulum"), tmp_path / "robot")
    return tmp_path / "robot"


@pytest.mark.parametrize("name", ROBOTS)
def test_the_samples_are_read_with_licence_and_source_beside_them(name):
    found = read_robot(name)
    assert len(found.trials) > 2 and all(trial.position.shape == trial.torque.shape for trial in found.trials)
    assert {"LICENSE", "SOURCE.txt"} <= {file.name for file in robot_folder(name).iterdir()}


def test_links_that_nobody_declared_are_noted(folder):
    urdf = folder / "model.urdf"
    urdf.write_text(urdf.read_text(encoding="utf-8").replace('<link name="world"/>', ""), encoding="utf-8")
    assert "massless: world" in read_robot(folder).notes[0]


def test_joints_are_told_by_name_in_any_order(folder):
    document = folder / "robot.toml"
    text = document.read_text(encoding="utf-8")
    turned = text.replace('["Joint1", "Joint2"]', '["Joint2", "Joint1"]').replace('"q1", "q2"', '"q2", "q1"')
    document.write_text(turned.replace('"tau1", "tau2"', '"tau2", "tau1"'), encoding="utf-8")
    one, other = RobotModel.of(read_robot("double-pendulum")), RobotModel.of(read_robot(folder))
    first, second = (model.predict_many([(model.neutral, trial) for trial in model.trials(0.25)[:3]]) for model in (one, other))
    for mine, theirs in zip(first, second, strict=True):
        assert mine["Joint1"] == pytest.approx(theirs["Joint1"]) and mine["Joint2"] == pytest.approx(theirs["Joint2"])


@pytest.mark.parametrize(
    ("file", "before", "after", "words"),
    [
        ("robot.toml", "[channels]", "[chanels]", ("keys among", "chanels")),
        ("robot.toml", 'urdf = "model.urdf"', 'urdf = "none.urdf"', ("a URDF", "none.urdf")),
        ("robot.toml", '"Joint2"]', '"Joint7"]', ("names among Joint1, Joint2", "Joint7")),
        ("robot.toml", '"q1", "q2"', '"q1"', ("for each of the 2 joints",)),
        ("robot.toml", "rotor_inertia = [0.00276, 0.00276]", "rotor_inertia = [0.1]", ("2 numbers",)),
        ("robot.toml", "torque_held = false", 'torque_held = "no"', ("true or false",)),
        ("robot.toml", "=", "", ("a TOML document",)),
        ("trial_02.csv", "t,q1,q2", "t,q1,qq", ("trial_02.csv:1", "a column q2")),
        ("trial_02.csv", "0.0069,", "O.0069,", ("trial_02.csv:3", "5 numbers")),
        ("trial_02.csv", "0.0069,", "9.0069,", ("trial_02.csv:4", "times that rise")),
        ("model.urdf", "</robot>", "", ("a URDF",)),
    ],
)
def test_a_fault_is_one_line_that_says_where_it_is(folder, file, before, after, words):
    place = folder / file
    text = place.read_text(encoding="utf-8")
    assert before in text
    place.write_text(text.replace(before, after, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_robot(folder)
    assert all(word in str(caught.value) for word in words) and "\n" not in str(caught.value)


def test_a_stretch_starts_where_the_encoders_show_the_robot_to_be():
    recordings = read_robot("double-pendulum")
    stretches = RobotModel.of(recordings).trials(0.5)
    assert len(stretches) > 20 and {each.labels["trial"] for each in stretches} == {t.name for t in recordings.trials}
    off = []
    for each in stretches:
        for k, joint in enumerate(recordings.robot.joints):
            assert each.inputs.q[k] == pytest.approx(each.measured[joint][0], abs=0.02)
            chord = (each.measured[joint][4] - each.measured[joint][0]) / (each.time[4] - each.time[0])
            off.append(abs(each.inputs.v[k] - chord))
            assert 0 < each.own[f"start speed of {joint}"] < 2
    assert np.median(off) < 0.3
    assert np.ptp([len(each.time) for each in stretches]) == 0
