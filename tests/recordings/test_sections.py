"""Version 2 of the format holds sections, the channels that drive them, and the orientation of bodies at markers."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Channel, Dataset, Marker, Section, Trial

TWO = (Section(0.14, 0.10, 1.6, 0.09), Section(0.10, 0.05, 1.4, 0.06))
ARM = ArmSpecification.in_sections(TWO, links=4, placement="mid")
TOML = """format = 2
name = "arm"

[robot]
length = 0.24
mass = 0.15
diameter = 0.04
mount = "hanging"
bending = "space"

[[section]]
length = 0.14
keq = 1.6
damping = 0.09

[[section]]
length = 0.1
keq = 1.4
damping = 0.06

[[input]]
section = 1
columns = ["P1", "P2", "P3"]
gain = 0.3
angle = 0.5

[[input]]
columns = ["pull"]
unit = "N"
torque = [[0.01, 0.0, 0.01, 0.002]]

[[measured]]
columns = ["P1 seen"]

[[marker]]
name = "tip"
arc_length = 0.24

[[trial]]
file = "a.csv"
"""
CSV = """t,P1,P2,P3,pull,P1 seen,tip_x,tip_y,tip_z
0.0,0.5,0.5,0.5,0.0,0.4,0.0,0.0,-0.24
0.01,2.0,0.5,0.5,0.0,0.5,0.0,0.0,-0.24
0.02,0.5,0.5,0.5,7.0,1.0,0.01,0.0,-0.239
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "dataset.toml").write_text(TOML)
    (tmp_path / "a.csv").write_text(CSV)
    return tmp_path


def dataset(channels=(), values=None):
    torque = [0.5, 0.2, -0.4, 0.3]
    motion = simulate(step_scenario(ARM, torque, duration=0.3, markers=(Marker("tip", 0.24),)), dynamics="compiled").trajectory
    motion = replace(motion, joint_angles=None, joint_rates=None, channels=values)
    numbers = {name: getattr(ARM, name) for name in ("length", "mass", "diameter", "mount", "bending")}
    trial = Trial("trial_01", motion, ARM.keq, ARM.damping)
    return Dataset("two", trials=(trial,), sections=TWO, channels=channels, **numbers)


def test_chambers_and_tendons_drive_the_sections_that_they_are_declared_to(folder):
    read = read_dataset(folder)
    trajectory = read.trials[0].trajectory
    way = 1.5 * 0.3 * np.array([np.cos(0.5), np.sin(0.5)])
    np.testing.assert_allclose(trajectory.torque, [[0, 0, 0, 0], [*way, 0, 0], [0.07, 0, 0.07, 0.014]], atol=1e-12)
    assert [channel.name for channel in read.channels] == ["P1", "P2", "P3", "pull", "P1 seen"]
    assert read.channels[-1] == Channel("P1 seen", "bar")
    np.testing.assert_array_equal(trajectory.channels[:, 4], [0.4, 0.5, 1.0])


def test_what_sections_are_together_is_the_arm(folder):
    read = read_dataset(folder)
    assert read.trials[0].keq == pytest.approx(1 / (1 / 1.6 + 1 / 1.4))
    assert [section.mass for section in read.sections] == pytest.approx([0.0875, 0.0625])
    arm = ArmSpecification.from_trial(read, read.trials[0])
    assert arm == ArmSpecification.in_sections(read.sections, length=0.24, mass=0.15, keq=arm.keq, damping=arm.damping)
    assert arm.damping == pytest.approx(0.09 * (0.14 / 0.24) ** 2 + 0.06 * (0.1 / 0.24) ** 2)


@pytest.mark.parametrize("driven", ["torques", "channels"])
def test_what_was_written_is_read_back(driven, tmp_path):
    channels, values = (), None
    if driven == "channels":
        channels = (*(Channel(f"c{k}", "N", tuple(np.eye(4)[k].tolist())) for k in range(4)), Channel("seen", "bar"))
        values = np.pad(dataset().trials[0].trajectory.torque, ((0, 0), (0, 1)))
    given = dataset(channels, values)
    write_dataset(given, tmp_path / "data")
    back = read_dataset(tmp_path / "data")
    assert (back.sections, back.channels) == (TWO, channels)
    for name in ("time", "positions", "torque", *(["channels"] if channels else ())):
        np.testing.assert_array_equal(getattr(back.trials[0].trajectory, name), getattr(given.trials[0].trajectory, name))


def test_uneven_times_are_put_onto_a_grid_with_their_channels(folder):
    rows = [f"{k / 100},0.5,0.5,0.5,{k},1.0,0.01,0.0,-0.239\n" for k in range(3, 30) if k != 20]
    (folder / "a.csv").write_text(CSV + "".join(rows))
    trajectory = read_dataset(folder).trials[0].trajectory
    np.testing.assert_array_equal(trajectory.channels[18:23, 3], [18, 19, 19, 21, 22])
    np.testing.assert_allclose(trajectory.torque[:, 3], 0.002 * trajectory.channels[:, 3])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("format = 2", "format = 1", "unknown key 'bending'|unknown key 'section'"),
        ('bending = "space"', 'bending = "plane"', 'section: expected bending = "space" together with this key, got plane'),
        ("length = 0.1\n", "length = 0.2\n", r"length: expected 0.34 m, the value of all sections together, got 0.24"),
        ("keq = 1.4\n", "", r"keq is missing in \[section\]"),
        ("keq = 1.4\n", "kek = 1.4\n", "unknown key 'kek'"),
        ("mass = 0.15", "mass = 0.15\nkeq = 2.0", "keq: expected 0.746667 Nm/rad, the value of all sections together, got 2"),
        ("section = 1\n", "", "section: expected the section that the columns bend, 1 to 2, or torque, got None"),
        ("section = 1\n", "section = 3\n", "section: expected the section that the columns bend, 1 to 2"),
        ("section = 1\n", "section = 1\ntorque = [[1,0,0,0]]\n", "section: expected either this key or torque"),
        ("[[0.01, 0.0, 0.01, 0.002]]", "[[0.01, 0.0]]", r"torque: expected 4 numbers \[N m per unit\] for each of 1 columns"),
        ('"P3"', '"P1"', "column 'P1' is declared twice"),
        ('"P3"', '"tip_x"', "column 'tip_x' is declared twice"),
        ('["pull"]', "[]", "columns: expected column names"),
        ('["pull"]', '["a,b"]', "columns: expected column names"),
        ("gain = 0.3", "gain = true", "gain: expected a number"),
    ],
)
def test_a_fault_of_the_declaration_is_named(folder, old, new, said):
    assert old in TOML
    (folder / "dataset.toml").write_text(TOML.replace(old, new))
    with pytest.raises(RecordingError, match=said):
        read_dataset(folder)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("pull,", "push,", "input columns: expected P1 and P2 and P3 and pull and P1 seen, or tau_x_1 and"),
        ("0.5,7.0", "0.5,", "column pull: expected a number, got no value"),
        ("P1,P2,P3,pull,P1 seen", "tau_x,tau_y,P3,pull,P1 seen", "input columns|unknown column 'tau_x'"),
    ],
)
def test_a_fault_of_the_columns_is_named(folder, old, new, said):
    assert old in CSV
    (folder / "a.csv").write_text(CSV.replace(old, new))
    with pytest.raises(RecordingError, match=said):
        read_dataset(folder)


def quaternions(frames):
    """(T, 4) of rotation matrices (T, 3, 3), the real part first."""
    w = np.sqrt(np.maximum(1 + frames[:, 0, 0] + frames[:, 1, 1] + frames[:, 2, 2], 0)) / 2
    turn = np.stack([frames[:, 2, 1] - frames[:, 1, 2], frames[:, 0, 2] - frames[:, 2, 0], frames[:, 1, 0] - frames[:, 0, 1]], 1)
    return np.column_stack([w, turn / (4 * w[:, None])])


@pytest.fixture
def posed(tmp_path):
    """An arm seen by a body 1 cm beside its tip, and the motion."""
    arm = ArmSpecification(3, placement="mid", bending="space", torsion=0.6, mount="upright")
    motion = simulate(step_scenario(arm, [0.4, 0.3], duration=0.3, markers=(Marker("tip", 0.24, 0.01, 2.0),))).trajectory
    places = space_marker_map(arm, [0.24])
    q = motion.joint_angles.reshape(len(motion.time), -1)
    frames = np.stack([places.normals(q), places.sides(q), places.tangents(q)], axis=-1)[:, 0]
    toml = TOML[: TOML.index("[[section]]")].replace("hanging", "upright") + TOML[TOML.index("[[marker]]") :]
    toml = toml.replace("arc_length = 0.24", "arc_length = 0.24\nradius = 0.01\nangle = 2.0\norientation = true")
    toml = toml.replace('bending = "space"', 'bending = "space"\nkeq = 1.11\ntorsion = 0.6')
    (tmp_path / "dataset.toml").write_text(toml)
    header = "t,tau_x,tau_y,tip_x,tip_y,tip_z,tip_qw,tip_qx,tip_qy,tip_qz"
    table = np.column_stack([motion.time, motion.torque, motion.positions[:, 0], quaternions(frames)])
    np.savetxt(tmp_path / "a.csv", table, "%.12f", ",", header=header, comments="")
    return tmp_path, arm, q


def test_a_body_is_seen_as_the_points_that_turn_with_it(posed):
    folder, arm, q = posed
    read = read_dataset(folder)
    assert [marker.name for marker in read.markers] == ["tip", "tip:x", "tip:y"]
    wanted = space_marker_map(arm, [0.24] * 3, [marker.offset for marker in read.markers]).positions(q)
    np.testing.assert_allclose(read.trials[0].trajectory.positions, wanted, atol=1e-10)
    assert np.linalg.norm(wanted[:, 1] - wanted[:, 0], axis=1) == pytest.approx(0.02)
    write_dataset(read, folder / "again")
    np.testing.assert_array_equal(
        read_dataset(folder / "again").trials[0].trajectory.positions, read.trials[0].trajectory.positions
    )


def test_an_orientation_that_was_not_seen_is_a_gap_and_one_that_is_none_is_refused(posed):
    lines = (posed[0] / "a.csv").read_text().splitlines()
    fields = lines[5].split(",")
    lines[5] = ",".join([*fields[:6], "", "", "", ""])
    (posed[0] / "a.csv").write_text("\n".join(lines))
    seen = np.isfinite(read_dataset(posed[0]).trials[0].trajectory.positions).all(axis=2)
    assert seen[4].tolist() == [True, False, False] and seen.sum() == seen.size - 2
    lines[5] = ",".join([*fields[:6], "1", "1", "0", "0"])
    (posed[0] / "a.csv").write_text("\n".join(lines))
    with pytest.raises(
        RecordingError, match=r"a.csv:6:\d+: orientation of marker tip: expected a quaternion of length 1, got 1.41"
    ):
        read_dataset(posed[0])


def test_an_orientation_in_a_plane_is_refused(folder):
    toml = TOML[: TOML.index("[[section]]")].replace('bending = "space"', "keq = 1.0") + TOML[TOML.index("[[marker]]") :]
    (folder / "dataset.toml").write_text(toml.replace("arc_length = 0.24", "arc_length = 0.24\norientation = true"))
    with pytest.raises(RecordingError, match="unknown key 'orientation'"):
        read_dataset(folder)
