"""The noise floor is that of the noise, whatever the arm does."""

import numpy as np
import pytest

from hsr_pin.recordings.noise import noise_floor, noise_per_axis
from hsr_pin.recordings.read import read_dataset
from hsr_pin.trajectory import Marker, Trajectory

TIME = np.arange(300) / 100


def release(time, frequency=2.0):
    return 1.5 * np.where(time < 0.5, 1.0, np.exp(-2 * (time - 0.5)) * np.cos(2 * np.pi * frequency * (time - 0.5)))


MOTIONS = {
    "rest": lambda time: 0.5 + 0 * time,
    "step": lambda time: np.where(time < 0.5, 0.0, 1.5 * (1 - np.exp(-8 * (time - 0.5)))),
    "release": release,
    "chirp": lambda time: 1.5 * np.sin(2 * np.pi * time**2 / 2),
}


def recording(bending, motion, sigma, seed=0, samples=300):
    rng = np.random.default_rng(seed)
    time = np.arange(samples) / 100
    positions = np.stack([bending(MOTIONS[motion](time), arc) for arc in (0.12, 0.24)], axis=1)
    return Trajectory(time, (Marker("mid", 0.12), Marker("tip", 0.24)), positions + sigma * rng.standard_normal(positions.shape))


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("sigma", [5e-5, 6e-4])
def test_white_noise_is_found_within_a_tenth_in_any_motion(bending, motion, sigma):
    found = np.mean([noise_floor(recording(bending, motion, sigma, seed)) for seed in range(20)], axis=0)
    assert np.allclose(found, sigma, rtol=0.1)


def test_each_axis_has_its_own_noise(bending):
    sigma = np.array([1e-4, 2e-4, 4e-4])
    found = noise_per_axis(recording(bending, "release", sigma, samples=3000))
    assert np.allclose(found, sigma, rtol=0.15)


def test_spikes_and_gaps_do_not_raise_it(bending):
    clean = recording(bending, "step", 5e-4, samples=1000)
    rng = np.random.default_rng(3)
    positions = np.array(clean.positions)
    positions[rng.random(1000) < 0.01] += 0.05
    positions[200:240] = np.nan
    dirty = Trajectory(clean.time, clean.markers, positions)
    assert np.allclose(noise_floor(dirty), noise_floor(clean), rtol=0.12)


def test_motion_without_noise_has_next_to_none(bending):
    assert np.all(noise_floor(recording(bending, "chirp", 0.0)) < 5e-6)


def test_a_marker_that_was_hardly_seen_has_no_figure(bending):
    trajectory = recording(bending, "rest", 1e-4)
    positions = np.array(trajectory.positions)
    positions[6:, 0] = np.nan
    floor = noise_floor(Trajectory(trajectory.time, trajectory.markers, positions))
    assert np.isnan(floor[0])
    assert np.isfinite(floor[1])


@pytest.mark.parametrize(
    "name, low, high", [("sample-steps", 2.5e-4, 3.5e-4), ("real-beam", 1e-6, 1e-5), ("real-trunk", 2e-6, 1e-4)]
)
def test_shared_recordings_have_the_noise_of_their_systems(shared, name, low, high):
    for trial in read_dataset(shared / "recordings" / name).trials:
        assert np.all((low < noise_floor(trial)) & (noise_floor(trial) < high))
