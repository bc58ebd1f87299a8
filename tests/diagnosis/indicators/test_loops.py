"""Hysteresis loops have their true width, and loops that fade are distinguished from lasting ones."""

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.loops import loops

from .recorded import STEP, arcs

LEVELS = np.array([0.0, 0.3, 0.6, 0.9, 0.6, 0.3, 0.0])
TIME = STEP * np.arange(700)
TORQUE = LEVELS[np.minimum((TIME + 1e-9).astype(int), 6)]
DOWN = TIME >= 4.0


def stairs(width):
    """Return bending of 0.8 times the command, plus ``width`` (T,) [rad] on the way down."""
    return 0.8 * TORQUE + np.where(DOWN, width, 0.0)


def test_a_width_that_lasts_is_friction():
    found = loops(arcs(*[stairs(0.05)] * 3, torques=[TORQUE] * 3, noise=5e-5))
    assert found.standing.value == pytest.approx(0.05 / 0.72, rel=0.05)
    assert found.kinds == ("friction",)
    assert "it does not fade during the plateaus" in found.sentence


def test_a_width_that_closes_by_waiting_is_creep():
    since = TIME % 1.0
    found = loops(arcs(*[stairs(0.08 * np.exp(-since / 0.5))] * 3, torques=[TORQUE] * 3, noise=5e-5))
    assert found.kinds == ("creep",)


def test_no_width_is_no_loop():
    found = loops(arcs(*[stairs(0.0)] * 3, torques=[TORQUE] * 3, noise=3e-4))
    assert found.kinds == () and "no lasting hysteresis loop" in found.sentence


def chirped(play, lag):
    """Return command and bending of a chirp through backlash (half width [rad]) with a lag [s]."""
    time = STEP * np.arange(1000)
    phase = 2 * np.pi * (0.2 * time + 0.05 * time**2)
    late = np.maximum(time - lag, 0)
    moved, bending = 0.0, np.empty(len(time))
    for index, target in enumerate(0.5 * (1 - np.cos(2 * np.pi * (0.2 * late + 0.05 * late**2)))):
        moved = float(np.clip(moved, target - play, target + play))
        bending[index] = moved
    return 0.5 * (1 - np.cos(phase)), bending


@pytest.mark.parametrize(("play", "lag", "kinds"), [(0.06, 0.02, ("friction",)), (0.0, 0.05, ())])
def test_cycles_tell_a_lag_from_a_loop_that_is_there_at_any_speed(play, lag, kinds):
    torque, bending = chirped(play, lag)
    found = loops(arcs(*[bending] * 3, torques=[torque] * 3, noise=5e-5))
    assert found.kinds == kinds
    assert found.lag.value == pytest.approx(lag - 0.5 * STEP, abs=0.006)  # a held command is half a sample late by itself


def test_a_command_from_one_side_only_shows_none():
    torque = np.where(TIME < 1.0, 0.0, 1.0)
    assert loops(arcs(0.8 * torque, torques=[torque])) is None
