"""Smoothed tracks are found by the colour of their noise, and simulated ones are smoothed alike."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, filtfilt, lfilter, savgol_filter

from hsr_pin.errors import RecordingError
from hsr_pin.identification.evaluation import predict_with_slopes
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.smoothing import detected, moving_average
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.recordings import clean, read_dataset, write_dataset
from hsr_pin.recordings.clean import moving_average as averaged

NOISE = 4e-4
TRUE = (1.1, 0.8)


@pytest.fixture(scope="module")
def exact(record):
    """Steps and a release without noise; stiffness and damping are off."""
    commands = [(1.11, 0.5), (1.11, 1.0), (1.11, -0.8), (2.33, 1.2), (2.33, -1.0), (1.11, None)]
    return record(commands, keq=TRUE[0], damping=TRUE[1], noise=0.0, seconds=2.0)


def seen(dataset, change, seed=0, noise=NOISE):
    """The dataset as a laboratory hands it on: with white noise, each track passed through ``change``."""
    generator = np.random.default_rng(seed)

    def passed(trial):
        positions = trial.trajectory.positions
        positions = change(positions + noise * generator.normal(size=positions.shape))
        return replace(trial, trajectory=replace(trial.trajectory, positions=positions))

    return replace(dataset, trials=tuple(passed(trial) for trial in dataset.trials))


def butterworth(order, cut):
    return lambda track: filtfilt(*butter(order, 2 * cut), track, axis=0)


@pytest.mark.parametrize("width", [3, 5, 9])
def test_a_moving_average_is_found_and_noise_stiffness_and_damping_come_out_true(exact, width):
    dataset = seen(exact, lambda track: averaged(track, width))
    experiment = prepare(dataset)
    assert experiment.notes[0].startswith(f"the tracks were smoothed by a moving average of {width} samples, as their noise")
    assert experiment.noise == pytest.approx(NOISE / np.sqrt(width), rel=0.12)
    found, ignored = (fit(each, Hypothesis()) for each in (experiment, prepare(replace(dataset, smoothed=1))))
    assert found.values == pytest.approx(TRUE, rel=0.005)
    assert np.sqrt(lasting_square(found.residuals)) < 1e-4 < 2.5e-4 < np.sqrt(lasting_square(ignored.residuals))


@pytest.mark.parametrize(
    ("change", "name", "error", "left"),
    [
        (lambda track: savgol_filter(track, 9, 2, axis=0), "a Savitzky-Golay filter of 9 samples", 0.01, 1e-4),
        (butterworth(4, 0.25), "a zero-phase Butterworth filter of order 4", 0.01, 1.5e-4),
        (butterworth(2, 0.2), "a zero-phase Butterworth filter of order 2", 0.01, 1.5e-4),
        (butterworth(4, 0.15), "a zero-phase Butterworth filter of order 4", 0.03, 1.5e-4),
    ],
)
def test_other_filters_are_found_and_little_error_remains(exact, change, name, error, left):
    experiment = prepare(seen(exact, change, seed=7))
    found = fit(experiment, Hypothesis())
    assert experiment.runs[0].smoothing.name.startswith(name)
    assert found.values == pytest.approx(TRUE, rel=error) and np.sqrt(lasting_square(found.residuals)) < left


def test_tracks_that_were_not_smoothed_are_not_said_to_be(exact):
    assert [seed for seed in range(200) if detected(seen(exact, lambda track: track, seed))] == []


@pytest.mark.parametrize("colour", [0.5, 0.9])
def test_coloured_noise_is_not_taken_for_smoothing(exact, colour):
    generator = np.random.default_rng(0)

    def drifting(track):
        return track + lfilter([NOISE], [1, -colour], generator.normal(size=track.shape), axis=0)

    assert [seed for seed in range(20) if detected(seen(exact, drifting, noise=0.0))] == []


@pytest.mark.parametrize("change", [lambda track: track, lambda track: np.round(track, 6), lambda track: np.round(track, 4)])
def test_motion_without_noise_is_not_taken_for_smoothed_noise(exact, change):
    assert detected(seen(exact, change, noise=0.0)) is None


def test_a_declared_width_counts_and_one_switches_it_off(exact):
    dataset = seen(exact, lambda track: averaged(track, 5))
    told = prepare(replace(dataset, smoothed=7))
    assert told.runs[0].smoothing.weights == pytest.approx(np.full(7, 1 / 7)) and "as declared in dataset.toml" in told.notes[0]
    off = prepare(replace(dataset, smoothed=1))
    assert off.runs[0].smoothing is None and not any("smoothed" in note for note in off.notes)


def test_predictions_and_their_derivatives_are_those_of_the_arm_filtered(exact):
    experiment = prepare(replace(exact, smoothed=5))
    plain = replace(experiment, runs=tuple(replace(run.whole, smoothing=None) for run in experiment.runs))
    answers = (predict_with_slopes(each, Hypothesis(), np.array(TRUE)) for each in (experiment, plain))
    for run, smooth, sharp in zip(experiment.runs, *answers, strict=True):
        inside = run.rows[(run.rows >= 2) & (run.rows < len(run.time) - 2)]
        kept = np.isin(run.rows, inside)
        assert len(inside) > 30 and set(np.diff(run.rows)) == {5}
        for one, other in ((smooth.positions, sharp.positions), (smooth.slopes, sharp.slopes)):
            assert one[kept] == pytest.approx(np.mean([other[inside + k] for k in range(-2, 3)], axis=0), abs=1e-9)


@pytest.mark.parametrize("width", [3, 5, 9])
def test_what_differences_of_smoothed_noise_tell_too_little_and_how_far_apart_it_is_white_is_known(width):
    noise = moving_average(width)(np.random.default_rng(0).normal(size=(200_000, 1)))[:, 0]
    rough = np.diff(noise, 4).std() / np.sqrt(70)
    assert moving_average(width).noise_factor == pytest.approx(noise.std() / rough, rel=0.02)
    assert moving_average(width).spacing == width


def test_the_declaration_is_read_and_written_and_an_even_width_refused(exact, tmp_path):
    write_dataset(replace(clean(exact), smoothed=5), tmp_path / "data")
    assert read_dataset(tmp_path / "data").smoothed == 5
    file = tmp_path / "data" / "dataset.toml"
    file.write_text(file.read_text().replace("smoothed = 5", "smoothed = 4"))
    with pytest.raises(RecordingError, match="an odd number of samples"):
        read_dataset(tmp_path / "data")
