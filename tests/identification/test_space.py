"""Fits are the same for arms that bend about two axes: the plane is a special case, and numbers of real ones are found."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.choice import choose
from hsr_pin.identification.comparison import compare
from hsr_pin.identification.evaluation import predict_all, predict_with_slopes
from hsr_pin.identification.experiment import prepare, restricted
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.identify import identify, simulated
from hsr_pin.identification.pose import pose_from_markers
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import rms
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

ARM = ArmSpecification(12, keq=0.8, damping=0.03, placement="mid", length=0.3, mass=0.3, bending="space", bending_limit=20.0)
MARKERS = (Marker("low", 0.1), Marker("mid", 0.2, 0.02, 2.0), Marker("tip", 0.3))
BEND = parse_effect("bend_at_rest:towards_x=0.2,towards_y=-0.1")
TWO = ("bend_at_rest.towards_x", "bend_at_rest.towards_y")
REACH, BESIDE = [marker.arc_length for marker in MARKERS], np.array([marker.offset for marker in MARKERS])
WAYS = ((0.7, 0.0), (-0.2, 0.6), (0.3, -0.5))


def recorded(trials, arm=ARM, effects=(), noise=1e-4, keq=0.5, damping=0.02):
    """A dataset of an arm that is declared softer than it is: for each trial two torques, or a pose that it is let go from."""
    time = np.arange(121) * 0.01
    stepped = time[:, None] >= 0.1 - 1e-9
    scenarios = [
        Scenario(arm, time, np.zeros((121, 2)), Pose(given), effects, MARKERS)
        if np.ndim(given) == 2
        else Scenario(arm, time, stepped * np.asarray(given), Settled(0.0), effects, MARKERS)
        for given in trials
    ]
    random, found = np.random.default_rng(1), []
    for number, (result, given) in enumerate(zip(simulate_batch(scenarios), trials, strict=True), 1):
        seen = result.raise_on_failure().trajectory.positions
        drive = None if np.ndim(given) == 2 else result.trajectory.torque
        if drive is None:
            seen = np.concatenate([np.repeat(seen[:1], 10, axis=0), seen[:-10]])
        seen = seen + noise * random.normal(size=seen.shape)
        found.append(Trial(f"trial_{number:02d}", Trajectory(time, MARKERS, seen, torque=drive), keq, damping, arm.tip_mass))
    return Dataset("wide", arm.length, arm.mass, arm.diameter, arm.mount, tuple(found), bending="space")


def bent(x, y):
    """A pose, bent most near the base."""
    return np.tile([x, y, 0.0], (12, 1)) * np.linspace(1.3, 0.7, 12)[:, None] / 12


def in_space(dataset):
    """A dataset of an arm in a plane, told as one in space."""

    def told(trial):
        torque = trial.trajectory.torque
        two = None if torque is None else np.stack([torque, np.zeros_like(torque)], axis=1)
        return replace(trial, trajectory=replace(trial.trajectory, torque=two))

    return replace(dataset, bending="space", trials=tuple(map(told, dataset.trials)))


def test_in_a_plane_space_predicts_what_the_plane_does(record, add_noise):
    dataset = record(((1.11, 0.5), (2.33, -1.2), (1.11, None)), noise=0.0)
    dataset = add_noise(dataset, lambda shape: 1e-4 * np.random.default_rng(3).normal(size=shape) * [1, 0, 1])
    model = Hypothesis((parse_effect("hysteresis:amplitude=0.3,yield_angle=0.1"),), ("keq_scale", "torque_gain"), links=6)
    values, flat, wide = np.array([1.1, 0.9]), prepare(dataset), prepare(in_space(dataset))
    starts = [  # noise is that of the axes, two or three; the release is told by it
        replace(own, start_pose=other.start_pose, start_velocity=other.start_velocity, lead=other.lead)
        for own, other in zip(wide.runs, flat.runs, strict=True)
    ]
    wide = replace(wide, noise=flat.noise, runs=tuple(starts))
    planar, whole = (predict_with_slopes(e, model, values) for e in (flat, wide))
    for plane, space in zip(planar, whole, strict=True):
        np.testing.assert_allclose(space.positions[..., [0, 2]], plane.positions, rtol=0, atol=1e-11)
        np.testing.assert_allclose(space.positions[..., 1], 0.0, atol=1e-11)
        np.testing.assert_allclose(space.slopes[..., [0, 2], :], plane.slopes, rtol=0, atol=1e-9)
    held = whole[2].nuisance  # how it was held: towards x, towards y; when it was let go; three stretches of a hand's hold, each
    np.testing.assert_allclose(held[..., [0, 2], :][..., [0, 2, 3, 5, 7]], planar[2].nuisance, atol=2e-7)
    assert np.abs(held[:, :, 1, 1]).max() > 0.5 * np.abs(held[:, :, 0, 0]).max()


def test_poses_are_those_that_the_markers_show():
    random = np.random.default_rng(2)
    batch = ArmBatch(Arms.of([ARM]), ())
    cameras = Cameras(batch, REACH, BESIDE)
    for _ in range(3):
        q, v = np.zeros((2, 12, 3))
        shape = np.stack([np.linspace(1, a, 12) for a in (0.2, 0.8)], axis=-1)
        q[:, :2], v[:, :2] = 0.08 * random.normal(size=2) * shape, random.normal(size=2) * shape
        q, v = q.reshape(1, 1, 36), v.reshape(1, 1, 36)
        seen, speed = cameras.positions(q)[0, 0], cameras.velocities(q, v)[0, 0]
        pose, rate, _ = pose_from_markers(batch, cameras, seen, speed, 1e-5)
        np.testing.assert_allclose(cameras.positions(pose[None])[0, 0], seen, atol=2e-5)
        np.testing.assert_allclose(pose, q[0], atol=5e-3)
        np.testing.assert_allclose(rate, v[0], atol=5e-2)
        one = seen.copy()
        one[1] = np.nan
        pose, _, _ = pose_from_markers(batch, cameras, one, speed, 1e-5)
        np.testing.assert_allclose(cameras.positions(pose[None])[0, 0], seen, atol=4e-3)


@pytest.mark.parametrize("effects", [(), (BEND,)])
def test_the_numbers_of_a_driven_arm_are_found(effects):
    dataset = recorded(WAYS, effects=effects)
    found = identify(dataset, free=("keq", "damping", *TWO) if effects else ("keq", "damping"), links=6)
    known = {"keq_scale": 1.6, "damping_scale": 1.5} | (dict(zip(TWO, (0.2, -0.1), strict=True)) if effects else {})
    for name, (low, high), value in zip(found.fit.hypothesis.free, found.uncertainty.interval, found.fit.values, strict=True):
        assert value == pytest.approx(known[name], abs=0.02)
        assert high - low < 0.1
    assert found.fit.rms < 6e-4 < 0.1 * rms(found.before)
    assert rms(found.heldout) < 6e-4
    if effects:
        without = fit(found.experiment, Hypothesis(links=6))
        assert without.rms > 5 * found.fit.rms


def test_the_numbers_of_a_released_arm_are_found():
    dataset = recorded([bent(*way) for way in ((1.2, 0.3), (-0.4, 1.0), (-0.8, -0.7))], replace(ARM, tip_mass=0.1), (BEND,))
    answer = identify(dataset, free=("keq", "damping", *TWO), links=6).fit
    assert answer.named == pytest.approx(
        {"keq_scale": 1.6, "damping_scale": 1.5, **dict(zip(TWO, (0.2, -0.1), strict=True))}, abs=0.03
    )
    assert answer.rms < 6e-4
    assert {n.shape[-1] for n in answer.nuisance} == {3}  # held towards x, towards y; when let go; by no hand


def test_where_a_trial_rests_is_its_own_in_two_directions():
    """Arms that rest anew in each trial are told from one that is bent: towards x the arm is, towards y it is chance."""
    dataset = recorded([(0.0, 0.0)] * 3 + [*WAYS] * 3, effects=(parse_effect("bend_at_rest:towards_x=0.2"),))
    shifts = np.random.default_rng(4).normal(size=(len(dataset.trials), 2)) * 3e-3

    def moved(trial, shift):
        way = trial.trajectory.positions / 0.3
        return replace(
            trial,
            trajectory=replace(
                trial.trajectory, positions=trial.trajectory.positions + np.array([*shift, 0.0]) * np.abs(way[..., 2:])
            ),
        )

    anew = replace(dataset, trials=tuple(map(moved, dataset.trials, shifts)))
    experiment = prepare(anew)
    assert experiment.rest_scatter == pytest.approx(3e-3, rel=0.3) and experiment.systematic == 2
    answer = fit(experiment, choose(("keq", "damping", *TWO), (), experiment.runs, links=6))
    assert answer.named["bend_at_rest.towards_x"] == pytest.approx(0.2, abs=0.03)
    assert {n.shape[-1] for n in answer.nuisance} == {2}
    assert answer.rms < 0.5 * rms(answer.raw_residuals)


def test_a_comparison_shows_both_components_of_the_torque():
    dataset = recorded([WAYS[1]], keq=ARM.keq, damping=ARM.damping)
    found = compare(dataset, links=8, placement="mid")
    assert found.errors[-1].rms < 1e-3
    simulated_one = found.trials[0].simulated
    np.testing.assert_allclose(simulated_one.torque[-1], WAYS[1])
    assert simulated_one.joint_angles.shape == (121, 8, 3)


def test_what_has_no_form_in_space_is_refused_in_one_line():
    dataset = recorded(WAYS[:1])
    with pytest.raises(IdentificationError, match="laws that are defined for arms in space, got torque_map"):
        identify(dataset, free=("keq",), effects=(parse_effect("torque_map:quadratic=0.1,parity=even"),))
    flat = replace(dataset, bending="plane")
    with pytest.raises(IdentificationError, match="input of trial_01"):
        prepare(flat)


def test_a_law_of_space_alone_is_refused_in_a_plane(steps):
    with pytest.raises(IdentificationError, match="laws that are defined for planar arms, got bend_at_rest"):
        identify(steps, free=("keq", "bend_at_rest"))


@pytest.mark.long
def test_a_real_trunk_is_bent_to_where_it_comes_to_rest(shared):
    """Fitted to the first two seconds of the releases with 200 g; told from their last samples, which lie beyond."""
    dataset = replace(read_dataset(shared / "recordings" / "real-trunk-space"), bending="space")
    experiment = prepare(dataset, delay=0.1)
    light = restricted(experiment, [run.trial.name for run in experiment.runs if run.trial.tip_mass == 0.2])
    cut = round(2 / light.runs[0].step)
    begun = tuple(replace(run, time=run.time[:cut], torque=run.torque[:cut], measured=run.measured[:cut]) for run in light.runs)
    short = replace(light, runs=begun)
    model = choose(("keq", "damping", "mass", *TWO), (), short.runs, links=8)
    found = fit(short, model).named
    bend = np.array([found[TWO[0]], -found[TWO[1]]])  # y of a hanging base is -y of the world
    rest = np.mean([run.measured[-20:, -1, :2].mean(axis=0) for run in light.runs], axis=0)
    assert bend @ rest > 0.9 * np.linalg.norm(bend) * np.linalg.norm(rest)
    assert np.linalg.norm(bend) > 0.05


def test_predictions_of_space_are_as_many_as_its_axes():
    experiment = prepare(recorded(WAYS[:1]))
    assert experiment.axes == (0, 1, 2) and experiment.noise_rms == pytest.approx(np.sqrt(3) * 1e-4, rel=0.2)
    found = predict_all(experiment, Hypothesis(links=4), np.array([1.6, 1.5]))
    assert found[0].positions.shape == (121, 3, 3)
    assert simulated(experiment, Hypothesis(links=4), np.array([1.6, 1.5]))[0].shape == (121, 3, 3)
