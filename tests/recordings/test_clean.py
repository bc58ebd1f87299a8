"""Cleaning makes gaps of what was wrong, says so, and touches nothing else."""

import dataclasses

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.recordings.clean import clean, moving_average
from hsr_pin.recordings.read import read_dataset
from hsr_pin.trajectory import Marker, Trajectory


@pytest.fixture
def dirty(bending):
    rng = np.random.default_rng(5)
    angle = np.sin(2 * np.pi * np.arange(400) / 200)
    markers = tuple(Marker(name, arc) for name, arc in (("base", 0.0), ("mid", 0.12), ("tip", 0.24)))
    true = np.stack([bending(angle, marker.arc_length) for marker in markers], axis=1)
    true += 3e-4 * rng.standard_normal(true.shape)
    positions = true.copy()
    positions[50, 2] += 0.03
    positions[200:205, [1, 2]] = true[200:205, [2, 1]]
    positions[300:320, 1] = np.nan
    return Trajectory(np.arange(400) / 100, markers, positions, torque=np.zeros(400), notes=("read",)), true


def test_spikes_become_gaps_exchanges_are_undone_and_the_rest_is_as_it_was(dirty):
    trajectory, true = dirty
    expected = true.copy()
    expected[50, 2] = np.nan
    expected[300:320, 1] = np.nan
    assert np.array_equal(clean(trajectory).positions, expected, equal_nan=True)


def test_what_was_done_is_said(dirty):
    notes = clean(dirty[0]).notes
    assert notes[0] == "read"
    assert notes[1].startswith("mid, tip: exchanged in 5 of 400 samples")
    assert notes[2].startswith("tip: 1 of 400 samples were removed as spikes")
    assert notes[3] == "mid: 20 of 400 samples are missing; the longest gap is 0.2 s"
    assert len(notes) == 4


def test_the_recording_given_is_not_changed(dirty):
    trajectory, _ = dirty
    before = np.array(trajectory.positions)
    clean(trajectory, smoothing=5)
    assert np.array_equal(trajectory.positions, before, equal_nan=True)
    assert trajectory.notes == ("read",)


def test_each_part_can_be_left_out(dirty):
    trajectory, _ = dirty
    kept = clean(trajectory, remove_spikes=False, restore_exchanges=False)
    assert np.array_equal(kept.positions, trajectory.positions, equal_nan=True)


def test_cleaning_twice_is_cleaning_once(dirty):
    once = clean(dirty[0])
    twice = clean(once)
    assert np.array_equal(once.positions, twice.positions, equal_nan=True)
    assert once.notes == twice.notes


def test_files_are_never_touched(folder):
    before = {path: path.read_bytes() for path in folder.iterdir()}
    clean(read_dataset(folder))
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_trial_and_a_dataset_are_cleaned_alike(dataset):
    cleaned = clean(dataset)
    for trial, other in zip(dataset.trials, cleaned.trials, strict=True):
        assert np.array_equal(clean(trial).trajectory.positions, other.trajectory.positions, equal_nan=True)
        assert dataclasses.replace(other, trajectory=trial.trajectory) == trial or other.keq == trial.keq


def test_a_moving_average_is_the_mean_of_what_was_seen_around():
    values = np.arange(10.0)[:, None, None] ** 2 * np.ones((10, 1, 3))
    values[4] = np.nan
    smooth = moving_average(values, 3)[:, 0, 0]
    assert smooth[0] == 0.0
    assert smooth[2] == pytest.approx((1 + 4 + 9) / 3)
    assert smooth[3] == pytest.approx((4 + 9) / 2)
    assert np.isnan(smooth[4])
    assert smooth[9] == 81.0


def test_smoothing_keeps_a_straight_line_and_lowers_noise():
    rng = np.random.default_rng(0)
    line = np.linspace(0, 1, 200)[:, None, None] * np.ones((200, 2, 3))
    assert np.allclose(moving_average(line, 9), line)
    noise = rng.standard_normal((2000, 1, 3))
    assert moving_average(noise, 9).std() == pytest.approx(1 / 3, rel=0.1)


@pytest.mark.parametrize("wrong", [{"smoothing": 4}, {"smoothing": 0}, {"half_window": 0}, {"threshold": 0.0}])
def test_settings_that_make_no_sense_are_refused(dirty, wrong):
    with pytest.raises(InputError):
        clean(dirty[0], **wrong)


def test_the_dirty_sample_loses_its_outliers_and_little_else(shared):
    """Its arm bends in x-z, so that y is nothing but noise and outliers: an oracle that fast motion cannot deceive."""
    dataset = read_dataset(shared / "recordings" / "sample-rich-dirty")
    removed = samples = 0
    sideways = []
    for before, after in zip(dataset.trials, clean(dataset).trials, strict=True):
        raw, kept = before.trajectory.positions, after.trajectory.positions
        removed += int((np.isnan(kept).any(axis=2) & np.isfinite(raw).all(axis=2)).sum())
        samples += 2 * len(raw)  # the base has no outliers
        sideways.append(np.abs(kept[..., 1][np.isfinite(kept[..., 1])]))
    assert 0.009 <= removed / samples <= 0.0105  # one in a hundred
    assert np.concatenate(sideways).max() < 7 * 6e-4
