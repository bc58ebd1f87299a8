"""Estimates of angle, speed and acceleration at the start of a stretch, with their errors, from encoder angles around it.

A cubic is fitted to the samples on both sides. A wide window averages more noise, and a narrow one follows the motion more
closely. The width is chosen for each joint by the expected square of the error of the speed over all starts: the variance from
noise plus the squared bias, which is estimated from the difference between a cubic and a quintic (J. Fan, I. Gijbels, Local
Polynomial Modelling and Its Applications, 1996, chapter 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array

#: Degree of the fitted polynomial, and of the one that shows its bias.
_DEGREE, _FINER = 3, 5
#: Smallest half-width of a window [samples], ratio of successive widths, and largest half-width [s].
_LEAST, _RATIO, _LONGEST = 3, 1.4, 0.1


@dataclass(frozen=True, eq=False)
class Starts:
    """Estimated states of n joints at S starts.

    Attributes:
        angle: (S, n) [rad].
        speed: (S, n) [rad/s].
        acceleration: (S, n) [rad/s^2].
        angle_error: (n,) standard deviation of the angles' errors [rad].
        speed_error: (n,) standard deviation of the speeds' errors [rad/s].
    """

    angle: Array
    speed: Array
    acceleration: Array
    angle_error: Array
    speed_error: Array


def half_windows(step: float) -> list[int]:
    """Return the half-widths that are tried [samples], for a sampling interval [s]."""
    widths = [_LEAST]
    while (wider := max(widths[-1] + 1, round(_RATIO * widths[-1]))) * step <= _LONGEST:
        widths.append(wider)
    return widths


def starts(time: Array, position: Array, begins: Sequence[int], noise: Array, resolution: Array) -> Starts:
    """Return the estimated states at some samples of a trial.

    Args:
        time: (N,) sampling times [s].
        position: (N, n) encoder angles [rad].
        begins: indices of the samples, each at least as far from both ends as the widest window.
        noise: (n,) standard deviation of the encoders' noise [rad].
        resolution: (n,) part of it that is rounding, which does not average out while a joint rests [rad].
    """
    step = float(np.median(np.diff(time)))
    tried = [_fits(time, position, begins, noise, width) for width in half_windows(step)]
    best = np.argmin([each.speed_error for each in tried], axis=0)
    joint = np.arange(position.shape[1])
    parts = (np.array([getattr(each, name) for each in tried]) for name in ("angle", "speed", "acceleration"))
    angle, speed, acceleration = (part[best, :, joint].T for part in parts)
    errors = (np.array([getattr(each, name) for each in tried])[best, joint] for name in ("angle_error", "speed_error"))
    angle_error, speed_error = errors
    return Starts(angle, speed, acceleration, np.hypot(angle_error, resolution), speed_error)


def _fits(time: Array, position: Array, begins: Sequence[int], noise: Array, width: int) -> Starts:
    """Return the estimates with one half-width [samples]."""
    found, variances, differences = [], [], []
    for at in begins:
        rows = slice(at - width, at + width + 1)
        span = time[at + width] - time[at]
        inverses = [np.linalg.pinv(np.vander((time[rows] - time[at]) / span, n + 1, increasing=True)) for n in (_DEGREE, _FINER)]
        scale = np.array([1.0, 1 / span])[:, None]
        cubic = inverses[0] @ position[rows]
        found.append(cubic[:3] * np.array([1.0, 1 / span, 2 / span**2])[:, None])
        variances.append((inverses[0][:2] ** 2).sum(axis=1)[:, None] * scale**2 * noise**2)
        other = (inverses[1][:2] - inverses[0][:2]) * scale
        differences.append((other @ position[rows]) ** 2 - (other**2).sum(axis=1)[:, None] * noise**2)
    values = np.reshape(found, (-1, 3, position.shape[1]))
    bias = np.maximum(np.mean(differences, axis=0), 0.0)
    errors = np.sqrt(np.mean(variances, axis=0) + bias)
    return Starts(*values.transpose(1, 0, 2), *errors)
