"""The error is that of the arm, not of its outliers; by marker, by phase, without any alignment."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.identification.comparison import compare
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trajectory, Trial


def recorded(shift=(0.0, 0.0, 0.0)):
    """A step of the paper's arm, every marker beyond the base seen beside where it is."""
    motion = simulate(step_scenario(ArmSpecification(), 0.8, duration=2.0)).trajectory
    seen = motion.positions + np.array([0.0, 1.0, 1.0])[:, None] * np.array(shift)
    trial = Trial("trial_01", Trajectory(motion.time, motion.markers, seen, torque=motion.torque), 1.11, 0.05)
    return Dataset("step", 0.24, 0.15, 0.04, "hanging", (trial,), chain=(4, "base"))


def test_what_the_simulation_made_compares_to_nothing():
    assert max(error.rms for error in compare(recorded()).errors) < 1e-6


def test_a_constant_shift_is_error_in_full_in_every_phase():
    for error in compare(recorded((0.003, 0.0, 0.004))).errors:
        assert [error.rms, error.p95, error.transient, error.settled] == pytest.approx([0.005] * 4, abs=1e-6)


def test_the_base_marker_tells_nothing_and_is_left_out():
    assert [error.marker for error in compare(recorded()).errors] == ["mid", "tip", "all"]


def test_outliers_change_the_error_of_the_dirty_sample_by_less_than_a_tenth(shared):
    dataset = read_dataset(shared / "recordings" / "sample-rich-dirty")

    def by_hand(trial):
        positions = trial.trajectory.positions.copy()
        around = np.nanmedian([np.roll(positions, shift, axis=0) for shift in range(-4, 5)], axis=0)
        out = (np.linalg.norm(positions - around, axis=2) > 0.006) | (np.abs(positions[:, :, 1]) > 0.003)
        positions[out] = np.nan
        return replace(trial, trajectory=replace(trial.trajectory, positions=positions)), int(out.sum())

    trials, counts = zip(*map(by_hand, dataset.trials), strict=True)
    assert sum(counts) > 100
    cleaned, handmade = (compare(data).errors[-1] for data in (dataset, replace(dataset, trials=trials)))
    assert cleaned.rms == pytest.approx(handmade.rms, rel=0.1)
