"""Version 2 of the format holds arms in space; version 1 is as it was."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.cli import sim
from hsr_pin.cli.command import run
from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Marker, Trial

ARM = ArmSpecification(3, placement="mid", bending="space", torsion=0.6)
MARKERS = (Marker("mid", 0.1, 0.02, 1.2), Marker("tip", 0.24))


@pytest.fixture
def dataset():
    """One step in space, seen at a marker beside the backbone and one on it."""
    motion = simulate(step_scenario(ARM, [0.5, 0.3], duration=0.4, markers=MARKERS), dynamics="compiled").trajectory
    trial = Trial("trial_01", replace(motion, joint_angles=None, joint_rates=None), ARM.keq, ARM.damping)
    numbers = {name: getattr(ARM, name) for name in ("length", "mass", "diameter", "mount", "bending", "torsion")}
    return Dataset("in-space", trials=(trial,), **numbers)


def test_what_was_written_is_read_back(dataset, tmp_path):
    write_dataset(dataset, tmp_path / "data")
    back = read_dataset(tmp_path / "data")
    assert (back.bending, back.torsion, back.markers) == ("space", 0.6, MARKERS)
    for name in ("time", "positions", "torque"):
        np.testing.assert_array_equal(getattr(back.trials[0].trajectory, name), getattr(dataset.trials[0].trajectory, name))
    arm = ArmSpecification.from_trial(back, back.trials[0], links=3, placement="mid")
    assert arm == ARM


def test_markers_beside_the_backbone_are_seen_there():
    motion = simulate(step_scenario(ARM, [0.5, 0.3], duration=0.2, markers=MARKERS), dynamics="compiled").trajectory
    q = motion.joint_angles.reshape(len(motion.time), -1)
    on, beside = space_marker_map(ARM, [0.1, 0.24]).positions(q), motion.positions
    np.testing.assert_allclose(np.linalg.norm(beside - on, axis=2), np.tile([0.02, 0.0], (len(q), 1)), atol=1e-15)


def test_a_dataset_without_torsion_does_not_twist(dataset, tmp_path):
    write_dataset(replace(dataset, torsion=np.inf), tmp_path / "data")
    assert "torsion" not in (tmp_path / "data" / "dataset.toml").read_text()
    assert read_dataset(tmp_path / "data").torsion == np.inf


def test_a_planar_dataset_is_written_as_version_1(heavy_tip, tmp_path):
    write_dataset(heavy_tip, tmp_path / "data")
    assert "format = 1" in (tmp_path / "data" / "dataset.toml").read_text()


def test_a_planar_dataset_may_say_version_2(heavy_tip, tmp_path):
    write_dataset(heavy_tip, tmp_path / "data")
    path = tmp_path / "data" / "dataset.toml"
    path.write_text(path.read_text().replace("format = 1", "format = 2"))
    assert read_dataset(tmp_path / "data").bending == "plane"


def test_hsr_sim_writes_it(tmp_path):
    arguments = ["--bending", "space", "--links", "3", "--duration", "0.4", "--torque", "0.5", "--direction", "0.4"]
    assert run(sim.command, [*arguments, "--csv", str(tmp_path / "data")]) == 0
    (trial,) = read_dataset(tmp_path / "data").trials
    np.testing.assert_allclose(trial.trajectory.torque[-1], 0.5 * np.array([np.cos(0.4), np.sin(0.4)]))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("format = 2", "format = 1", r"dataset.toml:\d+:1: unknown key 'bending'"),
        ('bending = "space"', 'bending = "round"', "bending: expected plane or space, got round"),
        ('bending = "space"', 'bending = "plane"', 'torsion: expected bending = "space" together with this key, got plane'),
        ("torsion = 0.6", "torsion = -1", "torsion: expected a number, zero or more"),
        ("radius = 0.02", "radius = -0.02", "radius: expected a number, zero or more"),
        ("radius = 0.02", "radius = 1e6", r"radius: expected from 0 to the arm's length, 0\.24 m, got 1000000"),
        ("radius = 0.02", "radios = 0.02", "unknown key 'radios'"),
    ],
)
def test_a_fault_of_the_declaration_is_named(dataset, tmp_path, old, new, said):
    write_dataset(dataset, tmp_path / "data")
    path = tmp_path / "data" / "dataset.toml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(RecordingError, match=said):
        read_dataset(tmp_path / "data")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("tau_x,tau_y", "tau_x,tau", "input columns|unknown column 'tau'"),
        ("tau_x,tau_y", "P1,P2", "unknown column 'P1'"),
    ],
)
def test_a_fault_of_the_columns_is_named(dataset, tmp_path, old, new, said):
    write_dataset(dataset, tmp_path / "data")
    path = tmp_path / "data" / "trial_01.csv"
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(RecordingError, match=said):
        read_dataset(tmp_path / "data")


def test_markers_beside_the_backbone_are_of_space_alone():
    with pytest.raises(InputError, match="markers: expected markers on the backbone"):
        step_scenario(ArmSpecification(), 0.5, markers=MARKERS)
