"""Rise and fall times are recovered, and a delay is distinguished from a slow response."""

import numpy as np
import pytest
from scipy.signal import lti
from scipy.signal import step as step_response

from hsr_pin.diagnosis.indicators.timing import timing

from .recorded import arcs

TIME = 0.005 * np.arange(1200)


def answered(up, down, delay=0.0):
    """Return bending and torque for a command up at 0.5 s and down at 3 s, with lags of these time constants."""
    since_up, since_down = np.maximum(TIME - 0.5 - delay, 0), np.maximum(TIME - 3.0 - delay, 0)
    risen = 1 - np.exp(-since_up / up)
    return np.where(3.0 + delay > TIME, risen, (1 - np.exp(-(2.5) / up)) * np.exp(-since_down / down)), np.where(
        (TIME > 0.5 - 1e-9) & (TIME < 3.0 - 1e-9), 1.0, 0.0
    )


def measured(*answers):
    return timing(arcs(*(bending for bending, _ in answers), torques=[torque for _, torque in answers], step=0.005, noise=5e-5))


def test_first_order_rise_and_fall_have_their_times():
    found = measured(*[answered(0.1, 0.3)] * 3)
    assert found.rise.value == pytest.approx(0.1 * np.log(9), rel=0.02)
    assert found.fall.value == pytest.approx(0.3 * np.log(9), rel=0.02)
    assert found.ratio.value == pytest.approx(3.0, rel=0.02)
    assert found.unequal and not found.late and found.kinds == ("actuation_time",)
    assert "falls 3.0 times as slowly" in found.sentence


def test_equal_times_of_a_lag_alone_look_like_those_of_a_damped_arm():
    found = measured(*[answered(0.2, 0.2)] * 3)
    assert not found.unequal and not found.late and found.kinds == ()


def test_a_delay_is_late():
    found = measured(*[answered(0.2, 0.2, delay=0.1)] * 3)
    assert found.late and not found.unequal


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.7, 1.0, 2.0])
def test_no_spring_mass_and_damper_is_late(ratio):
    after = TIME >= 0.5
    bending = np.zeros(len(TIME))
    times, response = step_response(lti([1.0], [0.1**2, 2 * ratio * 0.1, 1.0]), T=TIME)
    bending[after] = 0.5 * np.interp(TIME[after] - 0.5, times, response)
    found = measured(*[(bending, np.where(after, 1.0, 0.0))] * 3)
    assert found is None or not found.late


def test_a_step_that_the_arm_does_not_follow_tells_nothing():
    torque = np.where(TIME > 0.5, 1.0, 0.0)
    slow = 0.3 * np.minimum(TIME / 6, 1.0)
    assert measured((slow, torque)) is None
