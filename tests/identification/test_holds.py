"""What a logger repeats counts once; what a coarse camera shows of a resting arm is no repeat."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.identification.evaluation import predict_all, simulate_run
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.holds import clock, is_held, without_holds
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.input_form import best_form
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import residuals, rms

NOISE = 3e-4


def held(values, every):
    """Each ``every``-th of values (T, ...), repeated until the next."""
    return np.repeat(values[::every], every, axis=0)[: len(values)]


def changed(dataset, change):
    """A dataset of which each trajectory went through ``change``."""
    return replace(dataset, trials=tuple(replace(trial, trajectory=change(trial.trajectory)) for trial in dataset.trials))


def with_held_markers(dataset, every):
    return changed(dataset, lambda trajectory: replace(trajectory, positions=held(trajectory.positions, every)))


@pytest.fixture(scope="module")
def swings(record):
    """Steps of an arm that is as declared."""
    return record([(1.11, torque) for torque in (0.5, 1.0, -0.8, -1.2)], seconds=2.0, noise=NOISE)


@pytest.mark.parametrize("every", [2, 3, 12])
def test_repeats_of_a_logger_are_found_told_and_left_out(swings, every):
    experiment = prepare(with_held_markers(swings, every))
    assert experiment.notes[0].startswith(f"mid, tip: sample and hold; a new position is recorded every {every} samples")
    for run in experiment.runs:
        assert run.rows.tolist() == list(range(0, 201, every)) and np.isfinite(run.compared).all()
        assert np.isnan(np.delete(run.measured, run.rows, axis=0)).all()


@pytest.mark.parametrize(("every", "error"), [(3, 0.25), (12, 0.5)])  # of 268 samples, and of 68
def test_noise_and_arm_come_out_as_from_the_samples_that_were_taken(swings, every, error):
    experiment = prepare(with_held_markers(swings, every))
    assert experiment.noise == pytest.approx([NOISE, NOISE], rel=error)
    found = fit(experiment, Hypothesis())
    assert found.values == pytest.approx([1.0, 1.0], abs=0.02) and found.rms < 1.1 * np.sqrt(2) * NOISE


def test_a_held_sample_is_that_of_the_row_in_which_it_is_seen_first(swings):
    experiment = prepare(with_held_markers(swings, 12))
    truth = np.ones((1, 2))
    missed = {}
    for late in (-1, 0, 1):
        left = []
        for run in experiment.runs:
            whole = simulate_run(experiment, run.whole, Hypothesis(), truth).positions[:, 0][..., run.axes]
            left.append(whole[np.clip(run.rows + late, 0, len(whole) - 1)] - run.compared)
        missed[late] = rms(left)
    assert missed[0] < 0.5 * min(missed[-1], missed[1])
    assert rms(residuals(experiment, predict_all(experiment, Hypothesis(), truth[0]))) == pytest.approx(missed[0])


def test_a_recording_without_repeats_is_as_it_was(swings):
    experiment = prepare(swings)
    assert experiment.notes == () and all(run.rows is None and run.whole is run for run in experiment.runs)


@pytest.mark.parametrize("noise", [0.0, 2e-5, 1e-4, 3e-4])
def test_a_coarse_camera_is_not_taken_for_a_hold(swings, noise):
    """Rounded to 0.2 mm: at rest nine samples in ten and more are the one before, if there is little noise."""
    motion = [trial.trajectory.positions[:, 2] for trial in swings.trials]
    rest = np.tile(np.array([0.0013, 0.0, -0.2398]), (400, 1))
    slow = rest + np.linspace(0, 0.01, 400)[:, None]  # one digit every eight samples
    said = 0
    for seed in range(50):
        generator = np.random.default_rng(seed)
        tracks = [np.round((track + noise * generator.normal(size=track.shape)) / 2e-4) * 2e-4 for track in (*motion, rest, slow)]
        said += is_held(tracks)
    assert said == 0


def test_a_clock_of_a_command_is_found_and_steps_have_none():
    curve = np.sin(0.02 * np.arange(300))[:, None]
    assert clock(held(curve, 6)) == 6 and clock(curve) == 1
    assert clock((np.arange(300)[:, None] > 100) * 1.0) == 1
    assert np.abs(without_holds(held(curve, 6)) - curve)[:294].max() < 1e-2 < np.abs(held(curve, 6) - curve).max()


def test_a_command_that_the_logger_held_too_may_go_straight_from_one_new_sample_to_the_next(record):
    time = np.arange(401) * 0.01
    chirp = np.sin(2 * np.pi * (0.3 * time + 0.15 * time**2))
    dataset = record([(1.11, 0.8 * chirp), (1.11, 0.5 * chirp)], seconds=4.0, interpolated=True, noise=NOISE)
    logged = changed(dataset, lambda t: replace(t, positions=held(t.positions, 6), torque=held(t.torque, 6)))
    experiment = prepare(logged)
    alone = fit(experiment, Hypothesis())
    experiment, found = best_form(experiment, alone)
    assert all(run.interpolated for run in experiment.runs) and abs(alone.values[1] - 1) > 0.3
    assert found.values == pytest.approx([1.0, 1.0], abs=0.03)
