"""States at the starts of stretches are as exact as they are said to be."""

import numpy as np
import pytest

from hsr_pin.robots.start import half_windows, starts

STEP = 0.004


def errors(noise, frequency=1.0, rounding=0.0, step=STEP, seed=0):
    """Return the standardised errors of angle and speed (S,), and the standard deviation of the speeds' error [rad/s]."""
    time = np.arange(0, 8.0, step)
    turn = 2 * np.pi * frequency
    angle, speed = np.sin(turn * time), turn * np.cos(turn * time)
    seen = angle + noise * np.random.default_rng(seed).normal(size=len(time))
    if rounding:
        seen = np.round(seen / rounding) * rounding
    margin = half_windows(step)[-1]
    begins = range(margin, len(time) - margin, 7)
    resolution = np.array([rounding / np.sqrt(12)])
    found = starts(time, seen[:, None], begins, np.hypot(noise, resolution), resolution)
    away = found.angle[:, 0] - angle[list(begins)], found.speed[:, 0] - speed[list(begins)]
    return away[0] / found.angle_error, away[1] / found.speed_error, found.speed_error[0]


@pytest.mark.parametrize("frequency", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("noise", [2e-5, 5e-4])
def test_the_errors_have_the_stated_size(noise, frequency):
    angle, speed, _ = errors(noise, frequency)
    assert 0.4 < np.sqrt(np.mean(angle**2)) < 1.5
    assert 0.4 < np.sqrt(np.mean(speed**2)) < 1.5


def test_a_rounded_angle_has_an_error_of_at_most_about_its_rounding():
    angle, _, _ = errors(0.0, rounding=1e-3)
    assert np.sqrt(np.mean(angle**2)) < 1.5


def test_noise_is_averaged_over_more_samples_of_a_slow_motion():
    assert errors(5e-4, 0.3)[2] < 0.5 * errors(5e-4, 3.0)[2]


def test_the_error_of_the_speed_is_small_at_fifty_hertz():
    assert errors(2e-5, 1.0, step=0.02)[2] < 0.02 * 2 * np.pi
