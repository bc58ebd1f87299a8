"""Recordings of a robot are read, or refused with one line that gives the place of the fault."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.recordings.samples import ROBOTS, robot_folder
from hsr_pin.robots import RobotRecordings, RobotTrial, read_robot
from hsr_pin.robots.causes import CAUSES
from hsr_pin.robots.model import RobotModel
from hsr_pin.robots.servo import Servo
from hsr_pin.robots.simulation import Case, Stretch, simulate


@pytest.fixture
def folder(tmp_path):
    shutil.copytree(robot_folder("double-pendulum"), tmp_path / "robot")
    return tmp_path / "robot"


@pytest.mark.parametrize("name", ROBOTS)
def test_the_samples_are_readable_and_have_a_licence_and_a_source(name):
    found = read_robot(name)
    assert len(found.trials) > 2 and all(trial.position.shape == trial.command.shape for trial in found.trials)
    assert {"LICENSE", "SOURCE.txt"} <= {file.name for file in robot_folder(name).iterdir()}


def test_undeclared_links_are_noted(folder):
    urdf = folder / "model.urdf"
    urdf.write_text(urdf.read_text(encoding="utf-8").replace('<link name="world"/>', ""), encoding="utf-8")
    assert "massless: world" in read_robot(folder).notes[0]


def test_joints_are_identified_by_name_in_any_order(folder):
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
        ("trial_02.csv", "0.0069,", "9.0069,", ("trial_02.csv:4", "increasing times")),
        ("model.urdf", "</robot>", "", ("a URDF",)),
        ("robot.toml", "torque = [", "torques = [", ("either torque or target",)),
        ("robot.toml", "rotor_inertia = [0.00276, 0.00276]", 'rotor_inertia = ["a", "b"]', ("rotor_inertia of", "2 numbers")),
        ("robot.toml", "[channels]", '[units]\nposition = "grad"\n[channels]', ("one of rad, deg", "'grad'")),
        ("robot.toml", "[channels]", "[servo]\nstiffness = [1, 2]\n[channels]", ("target, because there is a [servo]",)),
        ("robot.toml", 'time = "t"', "", ("time among the [channels]",)),
        ("robot.toml", "[channels]", "[units]\nposition = [1]\n[channels]", ("one of rad, deg", "[1]")),
        ("robot.toml", "[channels]", 'encoders = "tip"\n[channels]', ("joint or motor", "'tip'")),
        ("trial_02.csv", "0.0069,", "0.0069,nan,", ("trial_02.csv:3", "finite numbers")),
    ],
)
def test_a_fault_is_reported_in_one_line_with_its_place(folder, file, before, after, words):
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


@pytest.fixture
def arm(folder):
    """Recordings of one arm that follows targets, with position in degrees and time in milliseconds."""
    for file in folder.glob("trial_*.csv"):
        file.unlink()
    text = (folder / "robot.toml").read_text(encoding="utf-8")
    text = text.replace("torque = [", "target = [").replace('"tau1", "tau2"', '"a", "b"').replace("torque_held = false", "")
    (folder / "robot.toml").write_text(text + '\n[units]\ntime = "ms"\nposition = "deg"\n', encoding="utf-8")
    robot = read_robot("double-pendulum").robot
    time = np.arange(0, 4, 0.005)
    target = np.column_stack([0.5 * np.sign(np.sin(3 * time)), 0.6 * np.sin(5 * time)])
    driven = replace(robot, servo=Servo.of(2, (20.0, 12.0), (1.0, 0.5), guessed=False))
    made = RobotRecordings("arm", driven, (RobotTrial("one", time, 0 * target, target),))
    model = RobotModel.of(made)
    start = Stretch(time, target, time[:1] - 1, target[:1], np.zeros(2), np.zeros(2), np.zeros(2), held=True)
    seen = simulate(driven, CAUSES, model.neutral, model.scales, [Case(start, model.neutral, np.zeros(2))])[0]
    table = np.column_stack([1e3 * time, np.degrees(seen), np.degrees(target)])
    np.savetxt(folder / "one.csv", table, delimiter=",", header="t,q1,q2,a,b", comments="", fmt="%.9g")
    return folder, seen, target


def test_targets_and_units_are_read(arm):
    folder, seen, target = arm
    with (folder / "robot.toml").open("a", encoding="utf-8") as file:
        file.write("[servo]\nstiffness = [20, 12]\ndamping = [1, 0.5]\n")
    found = read_robot(folder)
    assert found.trials[0].position == pytest.approx(seen) and found.trials[0].command == pytest.approx(target)
    assert found.trials[0].time[-1] == pytest.approx(3.995) and found.robot.servo.stiffness == (20.0, 12.0)
    assert not found.robot.servo.guessed and found.robot.servo.limit == (np.inf, np.inf)


def test_a_torque_constant_is_refused_beside_targets(arm):
    document = arm[0] / "robot.toml"
    document.write_text("torque_constant = [0.1, 0.1]\n" + document.read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(InputError, match="torque_constant"):
        read_robot(arm[0])


def test_an_undescribed_servo_is_estimated_from_its_recordings(arm):
    servo = read_robot(arm[0]).robot.servo
    assert servo.guessed
    assert servo.stiffness == pytest.approx((20.0, 12.0), rel=0.15) and servo.damping == pytest.approx((1.0, 0.5), rel=0.3)


def test_an_empty_target_is_a_servo_that_is_off(arm):
    file = arm[0] / "one.csv"
    lines = file.read_text(encoding="utf-8").splitlines()
    lines[-100:] = [line.rsplit(",", 2)[0] + ",," for line in lines[-100:]]
    file.write_text("\n".join(lines), encoding="utf-8")
    assert np.isnan(read_robot(arm[0]).trials[0].command[-100:]).all()


def test_bags_of_joint_states_are_read(folder):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.LATEST)
    given = read_robot(folder).trials[0]
    for file in folder.glob("trial_*.csv"):
        file.unlink()
    header, stamp, state = (
        store.types[name] for name in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", "sensor_msgs/msg/JointState")
    )
    with rosbag2.Writer(folder / "bag", version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for t, q, tau in zip(given.time, given.position, given.command, strict=True):
            at = round(1e9 * (t + 1e9))
            message = state(header(stamp(at // 10**9, at % 10**9), ""), ["a", "b"], q, np.zeros(2), tau)
            writer.write(topic, at, store.serialize_cdr(message, "sensor_msgs/msg/JointState"))
    (folder / "bag" / "bag.mcap").rename(folder / "one.mcap")
    document = folder / "robot.toml"
    text = document.read_text(encoding="utf-8").replace('time = "t"\n', "")
    for name, field in (("q", "position"), ("tau", "effort")):
        pair = ", ".join(f'"/joint_states:{field}[{n}]"' for n in (0, 1))
        text = text.replace(f'"{name}1", "{name}2"', pair)
    document.write_text(text, encoding="utf-8")
    (found,) = read_robot(folder).trials
    assert found.time == pytest.approx(given.time - given.time[0], abs=1e-6)
    assert found.position == pytest.approx(given.position) and found.command == pytest.approx(given.command)
