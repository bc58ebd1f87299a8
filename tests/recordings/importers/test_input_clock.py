"""An input on another clock than its motion is moved, noted or refused, and never taken as it is without a word."""

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.lag import find_lag, second_order_response

BODIES = (Body("base", ("Arm:base",), 0.0), Body("mid", ("Arm:mid",), 0.12), Body("tip", ("tip",), 0.24))


@pytest.fixture
def bring(tmp_path, laboratory, writers):
    """Import a motion whose input, a step at 0.5 s, stands in a file at times of another clock."""

    def bring(clock=lambda t: t, offset=()):
        lab = laboratory(noise=1e-4)
        writers["nexus"](tmp_path / "take.csv", lab.names, lab.positions)
        rows = [f"{clock(t)!r},{tau}" for t, tau in zip(lab.time.tolist(), lab.torque, strict=True)]
        (tmp_path / "in.csv").write_text("t,tau\n" + "\n".join(rows), encoding="utf-8")
        facts = {"markers": BODIES, "inputs": [tmp_path / "in.csv"], "input_offset": offset}
        return import_recordings([tmp_path / "take.csv"], ImportSettings(mass=0.15, diameter=0.04, keq=[1.11], **facts)).dataset

    return bring


def step_of(dataset):
    trajectory = dataset.trials[0].trajectory
    return trajectory.time[np.flatnonzero(trajectory.torque > 0.4)[0]]


def test_a_log_that_is_late_is_noted_with_how_late_and_one_that_is_not_is_not(bring):
    notes = bring(lambda t: t + 1.4).trials[0].trajectory.notes
    note = next(note for note in notes if "leads its command" in note)
    assert "give --input-offset -1.3" in note or "give --input-offset -1.4" in note
    assert not any("command" in note for note in bring().trials[0].trajectory.notes)


def test_an_offset_that_is_told_moves_the_input(bring):
    dataset = bring(lambda t: t + 1.4, [-1.4])
    assert step_of(dataset) == pytest.approx(0.5, abs=0.009)
    assert "input moved by -1.4 s, as given" in dataset.trials[0].trajectory.notes


@pytest.mark.parametrize("late", [1.4, -0.8, 7200.0])
def test_an_offset_is_estimated_from_the_motion_with_its_uncertainty(bring, late):
    dataset = bring(lambda t: t + late, ["auto"])
    assert step_of(dataset) == pytest.approx(0.5, abs=0.05)
    assert any(note.startswith("input moved by ") and " +- " in note for note in dataset.trials[0].trajectory.notes)


@pytest.mark.parametrize(
    "clock, hint",
    [
        (lambda t: 1000 * t, "if these are ms, give [input] time_unit in --map"),
        (lambda t: 1400 + 1000 * t, "if these are ms,"),
        (lambda t: 1.7e12 + 1000 * t, "if these are ms,"),
        (lambda t: 1e6 * t, "if these are us,"),
        (lambda t: 1.7e9 + t, "for Unix time"),
        (lambda t: t + 7200, "its clock is 2 h off; give --input-offset -7200, or auto"),
        (lambda t: t - 1234, "correct it with --input-offset S, or auto"),
    ],
)
def test_a_clock_that_does_not_meet_the_motion_is_refused(bring, clock, hint):
    with pytest.raises(RecordingError, match=r"the clock of the input: expected times of the recording, 0 to 2.99") as caught:
        bring(clock)
    assert hint in str(caught.value)


def test_a_motion_that_repeats_itself_does_not_tell_its_offset_and_noise_follows_nothing():
    time, log = np.arange(1000) / 100, np.arange(-1000, 2000) / 100
    wave = np.sin(2 * np.pi * time)
    assert find_lag(log, np.sin(2 * np.pi * log), time, wave).ambiguous
    assert not find_lag(time, wave, time, np.random.default_rng(0).standard_normal(1000)).follows
    assert find_lag(time, 0 * wave, time, wave) is None


@pytest.mark.parametrize("ratio", [0.1, 1.0, 3.0, 1e3])
def test_what_passes_a_second_order_system_is_its_exact_answer(ratio):
    time, frequency = np.arange(200) / 100, 8.0
    answer = second_order_response(np.where(time > 0, 1.0, 0.0), 0.01, frequency, ratio)[1:]
    turn = np.emath.sqrt(ratio**2 - 1) or 1e-6
    first, second = -frequency * (ratio + turn), -frequency * (ratio - turn)
    exact = 1 + (second * np.exp(first * time) - first * np.exp(second * time)) / (first - second)
    assert np.abs(answer - exact[:-1].real).max() < 1e-8


@pytest.mark.parametrize("late", [-0.5, 0.0, 0.3])
def test_a_lag_is_found_beside_what_the_arm_takes(late):
    time = np.arange(600) / 100
    noise = 1e-3 * np.random.default_rng(1).standard_normal(600)
    answer = second_order_response(np.where(time > 1, 1.0, 0.0), 0.01, 9.0, 0.4) + noise
    found = find_lag(time, np.where(time > 1 - late, 1.0, 0.0), time, answer, signed=True)
    assert abs(found.value - late) < 0.03 and found.sigma < 0.03
    assert found.is_early == (late < 0)
