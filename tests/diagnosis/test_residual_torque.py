"""The missing torque is recovered from marker tracks whose noise is smaller than their systematic error."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.residual_torque import residual_torques
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.inference.fit import fit

from .made import TRIALS, made

ARM = Hypothesis(links=12)


def missing(dataset):
    """Return the mean missing torque (T,) along the arm in each trial, without its ends [N m]."""
    experiment = prepare(dataset)
    return [each.torque.mean(axis=1)[10:-10] for each in residual_torques(experiment, fit(experiment, ARM), 0)]


def seen_along(dataset, shift):
    """Return the experiment with every marker displaced along the straight arm from its declared position."""
    step = np.array([0.0, 0.0, shift])

    def moved(trial):
        return replace(trial, trajectory=replace(trial.trajectory, positions=trial.trajectory.positions + step))

    return replace(dataset, trials=tuple(map(moved, dataset.trials)))


@pytest.mark.parametrize("noise", [1e-6, 1e-4])
def test_a_marker_that_is_half_a_millimetre_off_is_no_torque(noise):
    """A nearly straight arm would have to fold to move the marker there."""
    small = [(keq, damping, (0.1 * a, 0.05 * b)) for keq, damping, (a, b) in TRIALS[:3]]
    exact = made(trials=small, noise=noise, keq=1.0, damping=1.0)
    for one, other in zip(missing(exact), missing(seen_along(exact, 5e-4)), strict=True):
        assert np.abs(other - one).max() < 0.02


def test_a_torque_that_nobody_commanded_is_found_at_its_size():
    pushed = made("torque_bias:bias=0.2", trials=TRIALS[:3], noise=1e-6, keq=1.0, damping=1.0)
    experiment = prepare(pushed)
    alone = fit(experiment, ARM)
    neutral = replace(alone, values=ARM.start)
    found = [each.torque.mean(axis=1)[20:-20] for each in residual_torques(experiment, neutral, 0)]
    assert np.median(np.concatenate(found)) == pytest.approx(0.2, rel=0.15)
