"""Spikes and exchanged markers are found; fast motion is not taken for them."""

import numpy as np
import pytest

from hsr_pin.recordings.outliers import exchanges, spikes
from hsr_pin.recordings.read import read_dataset

TIME = np.arange(300) / 100
ARCS = (0.0, 0.12, 0.24)


def step(angle, frequency, damping):
    """A step response at 0.5 s of a second-order system."""
    since = np.maximum(TIME - 0.5, 0) * 2 * np.pi * frequency
    own = np.sqrt(1 - damping**2)
    return angle * (1 - np.exp(-damping * since) * (np.cos(own * since) + damping / own * np.sin(own * since)))


MOTIONS = {
    "slow step": step(1.0, 0.8, 0.7),
    "fast step": step(3.0, 3.0, 0.2),
    "very fast step": step(3.0, 5.0, 0.9),
    "release": 1.5 - step(1.5, 2.0, 0.05),
    "fast release": 3.0 - step(3.0, 4.0, 0.1),
    "chirp to 3 Hz": 1.5 * np.sin(2 * np.pi * 0.5 * TIME**2),
}


def arm(bending, motion, sigma, seed):
    rng = np.random.default_rng(seed)
    positions = np.stack([bending(MOTIONS[motion], arc) for arc in ARCS], axis=1)
    return positions + sigma * rng.standard_normal(positions.shape), rng


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("sigma", [0.0, 3e-4, 6e-4])
def test_fast_motion_is_not_taken_for_spikes(bending, motion, sigma):
    alarms = sum(int(spikes(arm(bending, motion, sigma, seed)[0]).sum()) for seed in range(4))
    assert alarms <= 4 * 1  # the first frame of a very fast release, at most, of 900 samples


@pytest.mark.parametrize("sigma", [3e-4, 6e-4])
def test_ninety_seven_of_a_hundred_spikes_are_found_and_almost_nothing_else(bending, sigma):
    found = there = alarms = samples = 0
    for motion in MOTIONS:
        for seed in range(5):
            positions, rng = arm(bending, motion, sigma, seed)
            hit = rng.random(positions.shape[:2]) < 0.01
            leap = rng.standard_normal((int(hit.sum()), 3))
            positions[hit] += 0.03 * leap / np.linalg.norm(leap, axis=1)[:, None] * rng.uniform(0.5, 2, (len(leap), 1))
            flagged = spikes(positions)
            found, there = found + int((flagged & hit).sum()), there + int(hit.sum())
            alarms, samples = alarms + int((flagged & ~hit).sum()), samples + hit.size
    assert there > 200
    assert found >= 0.97 * there
    assert alarms <= 5e-4 * samples


def test_a_burst_of_four_samples_is_found(bending):
    positions, _ = arm(bending, "slow step", 3e-4, 0)
    positions[150:154, 2] += 0.04
    assert np.flatnonzero(spikes(positions)[:, 2]).tolist() == [150, 151, 152, 153]


def test_gaps_are_not_spikes_and_do_not_hide_them(bending):
    positions, _ = arm(bending, "slow step", 3e-4, 0)
    positions[100:120] = np.nan
    positions[130, 1] += 0.03
    assert np.argwhere(spikes(positions)).tolist() == [[130, 1]]


def test_a_marker_never_seen_has_no_spikes():
    assert not spikes(np.full((50, 1, 3), np.nan)).any()


@pytest.mark.parametrize("motion", MOTIONS)
def test_markers_that_were_never_exchanged_are_left_as_they_are(bending, motion):
    positions, _ = arm(bending, motion, 6e-4, 0)
    assert np.array_equal(exchanges(positions), np.tile(np.arange(3), (300, 1)))


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("frames", [[40], list(range(60)), list(range(120, 200)), [60, 61, 150, 290]])
@pytest.mark.parametrize("pair", [(1, 2), (0, 1)])
def test_exchanged_markers_are_told_apart(bending, motion, frames, pair):
    true, _ = arm(bending, motion, 6e-4, 1)
    positions = true.copy()
    positions[np.ix_(frames, pair)] = true[np.ix_(frames, pair[::-1])]
    order = exchanges(positions)
    assert np.array_equal(np.take_along_axis(positions, order[:, :, None], axis=1), true)


def test_three_markers_may_change_places_in_a_ring(bending):
    true, _ = arm(bending, "release", 3e-4, 1)
    positions = true.copy()
    positions[80:90] = true[80:90][:, [1, 2, 0]]
    assert np.array_equal(np.take_along_axis(positions, exchanges(positions)[:, :, None], axis=1), true)


def test_an_exchange_beside_a_spike_or_a_gap_is_still_found(bending):
    true, _ = arm(bending, "release", 3e-4, 1)
    positions = true.copy()
    positions[100:110, [1, 2]] = true[100:110, [2, 1]]
    positions[99, 1] += 0.03
    positions[80:95, 2] = np.nan
    assert np.flatnonzero((exchanges(positions) != np.arange(3)).any(axis=1)).tolist() == list(range(100, 110))


def test_two_spikes_in_one_frame_are_no_exchange(bending):
    positions, _ = arm(bending, "release", 3e-4, 1)
    positions[100, 1:] += 0.1
    assert np.array_equal(exchanges(positions), np.tile(np.arange(3), (300, 1)))


@pytest.mark.parametrize("name, most", [("sample-steps", 0), ("real-beam", 0)])
def test_clean_shared_recordings_have_no_spikes(shared, name, most):
    dataset = read_dataset(shared / "recordings" / name)
    assert sum(int(spikes(trial.trajectory.positions).sum()) for trial in dataset.trials) <= most


def test_no_shared_recording_has_exchanged_markers(shared):
    for name in ("sample-steps", "sample-rich-dirty", "real-beam", "real-trunk"):
        for trial in read_dataset(shared / "recordings" / name).trials:
            order = exchanges(trial.trajectory.positions)
            assert np.array_equal(order, np.tile(np.arange(order.shape[1]), (len(order), 1)))
