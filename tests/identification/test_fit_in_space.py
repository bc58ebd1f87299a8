"""Releases in space give back the numbers of the arm that made them, and say where a real one is bent at rest."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.errors import IdentificationError, InputError
from hsr_pin.identification.fit_in_space import fit_in_space, releases_of
from hsr_pin.identification.pose_in_space import poses_in_space
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Pose, Scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Marker, Trial

ARM = ArmSpecification(8, keq=0.8, damping=0.03, placement="shifted", length=0.3, mass=0.3, bending="space", bending_limit=20.0)
MARKERS = (Marker("low", 0.1), Marker("mid", 0.2), Marker("tip", 0.3))
BEND = parse_effect("bend_at_rest:towards_x=0.2,towards_y=-0.1")


@pytest.fixture(scope="module")
def dataset():
    """Four releases of an arm that is bent at rest, under two loads, with a noise of 0.1 mm; declared too soft and light."""
    random, trials = np.random.default_rng(1), []
    for number, (x, y, load) in enumerate(((0.12, 0.0, 0.1), (0.0, 0.13, 0.2), (-0.1, 0.08, 0.2), (0.05, -0.12, 0.1)), 1):
        pose = np.tile([x, y, 0.0], (8, 1)) * np.linspace(1.3, 0.7, 8)[:, None]
        time = np.arange(151) * 0.01
        scenario = Scenario(replace(ARM, tip_mass=load), time, np.zeros((151, 2)), Pose(pose), (BEND,), MARKERS)
        motion = simulate(scenario, dynamics="compiled").trajectory
        held = np.concatenate([np.repeat(motion.positions[:1], 10, axis=0), motion.positions])
        seen = replace(
            motion,
            time=np.arange(161) * 0.01,
            positions=held + 1e-4 * random.normal(size=held.shape),
            torque=None,
            joint_angles=None,
            joint_rates=None,
        )
        trials.append(Trial(f"trial_{number:02d}", seen, 0.5, 0.02, load, t_start=0.1))
    return Dataset("bent", 0.3, 0.2, 0.04, "hanging", tuple(trials), bending="space")


def test_poses_are_those_that_the_markers_show():
    random = np.random.default_rng(2)
    shape = np.stack([np.linspace(1, a, 8) for a in (0.2, 0.8)], axis=-1)
    q, v = np.zeros((2, 3, 8, 3))
    q[..., :2], v[..., :2] = 0.12 * random.normal(size=(3, 1, 2)) * shape, random.normal(size=(3, 1, 2)) * shape
    places = space_marker_map(ARM, [marker.arc_length for marker in MARKERS])
    flat, moving = q.reshape(3, 24), v.reshape(3, 24)
    poses, rates = poses_in_space(places, 8, places.positions(flat), places.velocities(flat, moving), 1e-5)
    np.testing.assert_allclose(places.positions(poses.reshape(3, 24)), places.positions(flat), atol=2e-5)
    np.testing.assert_allclose(poses, q, atol=5e-3)
    np.testing.assert_allclose(rates, v, atol=5e-2)


def test_a_marker_that_is_not_seen_is_done_without():
    q = np.tile([0.1, -0.05, 0.0], (1, 8, 1)).reshape(1, 24)
    places = space_marker_map(ARM, [marker.arc_length for marker in MARKERS])
    shown = places.positions(q)
    shown[0, 1] = np.nan
    poses, _ = poses_in_space(places, 8, shown, np.zeros_like(shown), 1e-5)
    np.testing.assert_allclose(places.positions(poses.reshape(1, 24)), places.positions(q), atol=2e-3)


def test_the_numbers_of_the_arm_are_found(dataset):
    releases = releases_of(dataset, delay=0.05, duration=1.2)
    start = parse_effect("bend_at_rest:towards_x=0,towards_y=0")
    found = fit_in_space(
        dataset, releases, ("keq", "damping", "mass", "bend_at_rest.towards_x", "bend_at_rest.towards_y"), (start,)
    )
    assert found.values["keq"] == pytest.approx(0.8, rel=0.02)
    assert found.values["damping"] == pytest.approx(0.03, rel=0.02)
    assert found.values["mass"] == pytest.approx(0.3, rel=0.05)
    assert found.values["bend_at_rest.towards_x"] == pytest.approx(0.2, abs=0.005)
    assert found.values["bend_at_rest.towards_y"] == pytest.approx(-0.1, abs=0.005)
    assert found.rms < 6e-4
    without = fit_in_space(dataset, releases)
    assert without.rms > 5 * found.rms


def test_numbers_are_judged_by_releases_that_they_were_not_fitted_to(dataset):
    releases = releases_of(dataset, delay=0.05, duration=1.2)
    found = fit_in_space(dataset, releases[:2], ("keq", "damping"))
    assert {*found.predicted(dataset, releases[2:]).errors} == {"trial_03", "trial_04"}
    assert found.predicted(dataset, releases[:2]).rms == pytest.approx(found.rms)


def test_what_cannot_be_fitted_is_said(dataset):
    with pytest.raises(IdentificationError, match="goes on for 5 s"):
        releases_of(dataset, duration=5.0)
    with pytest.raises(InputError, match="parameter: expected keq"):
        fit_in_space(dataset, releases_of(dataset, duration=1.0), ("stiffness",))


@pytest.mark.long
def test_a_real_trunk_is_bent_to_where_it_comes_to_rest(shared):
    """Fitted to the motion of the releases with 200 g; told from their last samples, which lie beyond what is fitted."""
    dataset = read_dataset(shared / "recordings" / "real-trunk-space")
    light = [each for each in releases_of(dataset) if each.trial.tip_mass == 0.2]
    start = parse_effect("bend_at_rest:towards_x=0,towards_y=0")
    names = ("keq", "damping", "mass", "bend_at_rest.towards_x", "bend_at_rest.towards_y")
    found = fit_in_space(dataset, light, names, (start,)).values
    bend = np.array([found["bend_at_rest.towards_x"], -found["bend_at_rest.towards_y"]])  # y of a hanging base is -y of the world
    rest = np.mean([each.trial.trajectory.positions[-20:, -1, :2].mean(axis=0) for each in light], axis=0)
    assert bend @ rest > 0.9 * np.linalg.norm(bend) * np.linalg.norm(rest)
