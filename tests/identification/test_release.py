"""How a release starts: where its markers are, how fast, and at which instant."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.release import start_of
from hsr_pin.trajectory import Marker, Trajectory, Trial

REACH = np.array([0.08, 0.16, 0.24])
MARKERS = tuple(Marker(f"m{i}", s) for i, s in enumerate(REACH))


def trial_of(x, step=0.01, **more):
    """One in which the markers are displaced along x by ``x`` (T,) [m]."""
    positions = np.zeros((len(x), 3, 3))
    positions[:, :, 2] = -REACH
    positions[:, :, 0] = np.asarray(x)[:, None]
    return Trial("t", Trajectory(step * np.arange(len(x)), MARKERS, positions), 1.0, t_start=0.1, **more)


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


def test_a_release_is_followed_from_a_delay_on_with_the_velocity_it_has_there(record):
    dataset = record([(1.11, None)], seconds=0.8, noise=1e-5)
    (run,) = prepare(dataset, delay=0.05).runs
    seen = dataset.trials[0].trajectory.positions[:, 1:]
    assert run.time[0] == pytest.approx(0.05)
    assert run.start_velocity == pytest.approx((seen[6] - seen[4]) / 0.02, abs=0.1 * np.abs(seen[6] - seen[4]).max() / 0.02)


def test_a_delay_that_cannot_be_is_refused(steps):
    with pytest.raises(IdentificationError, match="delay"):
        prepare(steps, delay=-0.1)


@pytest.mark.parametrize("seen", [True, False])
def test_an_arm_that_is_let_go_at_its_last_sample_starts_there(seen):
    late = replace(trial_of(np.full(60, 0.05)), t_start=0.585)
    positions = np.array(late.trajectory.positions)
    positions[-1] = positions[-1] if seen else np.nan
    assert start_of(replace(late, trajectory=replace(late.trajectory, positions=positions)), 1e-4).sample == 59
