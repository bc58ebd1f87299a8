"""Creep is measured with its true size, and is not found where the arm only oscillates or is slow."""

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.creep import creep

from .recorded import STEP, arcs, swing

SINCE = STEP * np.arange(601)


def crept(decade):
    """Return bending (T,) [rad] from 0.6 to 0 by a lag of 50 ms, with creep by a share of the step in every decade of time."""
    way = (1 - np.exp(-SINCE / 0.05)) * (1 + decade * np.log10(np.maximum(SINCE, STEP) / SINCE[-1]))
    return 0.6 - 0.6 * way


@pytest.mark.parametrize("decade", [0.03, 0.1])
def test_a_logarithmic_creep_is_measured(decade):
    found = creep(arcs(*[crept(decade)] * 3, noise=5e-5))
    assert found.decade.value == pytest.approx(decade, rel=0.1)
    assert found.kinds == ("creep",)


def test_a_lag_alone_is_no_creep():
    assert creep(arcs(*(0.6 * np.exp(-SINCE / tau) for tau in (0.1, 0.2, 0.4)), noise=5e-5)).kinds == ()


def test_ringing_is_no_creep():
    assert creep(arcs(*(swing(angle, 2.0, 0.1, duration=6.0) for angle in (0.5, 0.7, 0.9)), noise=5e-5)).kinds == ()


def test_a_short_recording_cannot_tell():
    assert creep(arcs(crept(0.1)[:25])) is None


def test_after_steps_a_supply_may_be_the_cause():
    bending = np.concatenate([np.zeros(50), 0.6 - crept(0.1)])
    torque = np.where(np.arange(651) < 50, 0.0, 1.0)
    found = creep(arcs(*[bending] * 3, torques=[torque] * 3, noise=5e-5))
    assert found.kinds == ("creep", "actuation_time")
