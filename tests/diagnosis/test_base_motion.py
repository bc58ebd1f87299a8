"""A moving base predicts the gap; a fixed base, or an independently moving one, does not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

from hsr_pin.diagnosis.base_motion import base_motion
from hsr_pin.identification.experiment import prepare

from .made import made

STEP = 0.02


def shaken(seed, size=0.003):
    """Return six trials whose base marker moves by a smooth, different path (T,) [m] in each."""
    generator, dataset = np.random.default_rng(seed), made()
    time, moved = dataset.trials[0].trajectory.time, []
    for trial in dataset.trials:
        phase, pace = generator.uniform(0, 6, 2), generator.uniform(8, 25, 2)
        move = size * (np.sin(pace[0] * time + phase[0]) + np.sin(pace[1] * time + phase[1]))
        positions = trial.trajectory.positions.copy()
        positions[:, 0, 0] += move
        moved.append((replace(trial, trajectory=replace(trial.trajectory, positions=positions)), move))
    return prepare(replace(dataset, trials=tuple(trial for trial, _ in moved))), [move for _, move in moved]


def swung(move):
    """Return positions (T, 2, 2) [m] of two markers on a lightly damped pendulum (1.6 Hz, 10 %) on a moving base."""
    time = STEP * np.arange(len(move))
    _, tip, _ = lsim(([-1.0, 0.0, 0.0], [1.0, 2.0, 100.0]), move - move[0], time)
    gap = np.zeros((len(move), 2, 2))
    gap[:, 0, 0], gap[:, 1, 0] = 0.5 * tip, tip
    return gap


def test_a_gap_that_follows_the_base_is_predicted_by_it():
    experiment, moves = shaken(0)
    found = base_motion(experiment, [swung(move) for move in moves])
    assert found.kind == "measurement" and found.predicted > 0.6
    assert "the base moves" in found.sentence


@pytest.mark.parametrize("size", [0.003, 0.0])
def test_a_gap_that_goes_its_own_way_is_not(size):
    experiment, _ = shaken(0, size)
    _, others = shaken(1)
    found = base_motion(experiment, [swung(move) for move in others])
    assert (found.kind, found.sentence) == ("", "") and found.predicted < 0.2


def test_without_a_marker_at_the_base_nothing_is_said():
    experiment = prepare(made(markers=(0.5, 1.0)))
    assert base_motion(experiment, [np.ones((len(run.time), 2, 2)) for run in experiment.runs]) is None
