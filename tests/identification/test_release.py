"""How a release starts: its pose, its velocity, and its instant, from the markers alone."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.release import start_of, state_from_markers
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Marker, Trajectory, Trial

REACH = np.array([0.08, 0.16, 0.24])
MARKERS = tuple(Marker(f"m{i}", s) for i, s in enumerate(REACH))


def trial_of(x, step=0.01, **more):
    """One in which the markers are displaced along x by ``x`` (T,) [m]."""
    positions = np.zeros((len(x), 3, 3))
    positions[:, :, 2] = -REACH
    positions[:, :, 0] = np.asarray(x)[:, None]
    return Trial("t", Trajectory(step * np.arange(len(x)), MARKERS, positions), 1.0, t_start=0.1, **more)


def test_pose_and_rates_put_the_markers_where_they_were_seen_and_moving_as_they_did():
    arm = build_model(ArmSpecification(links=8, placement="mid"))
    s = 2 * arm.specification.element_arc_lengths - 1
    angles, rates = (0.9 + 0.3 * s) / 8, (2.0 - 1.0 * s) / 8
    places = marker_map(arm, REACH)
    seen = places.positions(angles)
    velocity = (places.positions(angles + 1e-6 * rates) - places.positions(angles - 1e-6 * rates)) / 2e-6
    q, v = state_from_markers(arm, REACH, seen, velocity, 1e-4)
    moving = (places.positions(q + 1e-6 * v) - places.positions(q - 1e-6 * v)) / 2e-6
    assert np.abs(places.positions(q) - seen).max() < 1e-5
    assert np.abs(moving - velocity).max() < 1e-2 * np.abs(velocity).max()


def test_a_marker_that_is_not_seen_does_not_bend_the_arm():
    arm = build_model(ArmSpecification(links=8, placement="mid"))
    seen = marker_map(arm, REACH).positions(np.full(8, 0.1))
    seen[1] = np.nan
    q, _ = state_from_markers(arm, REACH, seen, np.zeros((3, 3)), 1e-4)
    assert np.abs(q - 0.1).max() < 1e-3


@pytest.mark.parametrize("late", [0.002, 0.005, 0.009])
def test_a_release_between_two_samples_is_found_to_a_tenth_of_a_sample(late):
    t = 0.01 * np.arange(60)
    start = start_of(trial_of(0.05 - 4.0 * np.maximum(t - 0.12 - late, 0.0) ** 2 / 2), 1e-6)
    assert 0.01 * (start.sample - start.lead) == pytest.approx(0.12 + late, abs=1e-3)
    assert np.all(start.velocity == 0)


def test_an_arm_that_moves_at_its_declared_start_starts_with_its_velocity():
    t = 0.01 * np.arange(60)
    start = start_of(trial_of(0.05 - 4.0 * t**2 / 2), 1e-6)
    assert (start.sample, start.lead) == (10, 0.0)
    assert start.velocity[:, 0] == pytest.approx(-0.4)
    assert start.pose[:, 0] == pytest.approx(0.03)


def test_noise_alone_is_not_taken_for_motion():
    x = 0.05 + 3e-4 * np.random.default_rng(0).normal(size=60)
    x[12:] -= 4.0 * (0.01 * np.arange(48)) ** 2 / 2
    assert np.all(start_of(trial_of(x), 3e-4).velocity == 0)


def test_what_happens_after_its_start_does_not_change_where_a_release_starts_from(record):
    dataset = record([(1.11, None)], seconds=0.8)
    trial = dataset.trials[0]
    later = np.array(trial.trajectory.positions)
    later[40:] += 0.02
    changed = replace(trial, trajectory=replace(trial.trajectory, positions=later))
    first, second = (start_of(each, 3e-4) for each in (trial, changed))
    assert np.array_equal(first.pose, second.pose)
    assert (first.sample, first.lead) == (second.sample, second.lead)


def test_an_arm_held_by_a_couple_bends_most_where_it_is_soft():
    arm = build_model(ArmSpecification(links=12, placement="mid"))
    stiffness = np.where(np.arange(12) == 5, 0.3, 1.0)
    held = 0.8 / 12 / stiffness
    seen = marker_map(arm, REACH).positions(held)
    q, _ = state_from_markers(arm, REACH, seen, np.zeros((3, 3)), 1e-4, stiffness)
    assert q == pytest.approx(held, abs=0.02 * held.max())
    uniform, _ = state_from_markers(arm, REACH, seen, np.zeros((3, 3)), 1e-4)
    assert np.abs(uniform - held).max() > 0.3 * held.max()


def test_a_release_is_followed_from_a_delay_on_with_the_velocity_it_has_there(record):
    dataset = record([(1.11, None)], seconds=0.8, noise=1e-5)
    (run,) = prepare(dataset, delay=0.05).runs
    seen = dataset.trials[0].trajectory.positions[:, 1:]
    assert run.time[0] == pytest.approx(0.05)
    assert run.start_velocity == pytest.approx((seen[6] - seen[4]) / 0.02, abs=0.1 * np.abs(seen[6] - seen[4]).max() / 0.02)


def test_a_delay_that_cannot_be_is_refused(steps):
    with pytest.raises(IdentificationError, match="delay"):
        prepare(steps, delay=-0.1)
