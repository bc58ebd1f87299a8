"""The initial state of a motion that does not start at rest: marker positions, velocities and the release instant."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array, Trajectory, Trial

#: Number of samples up to the start from which the held pose is averaged, and by which a resting arm is recognised.
_WINDOW = 5
#: Number of samples on both sides of the start for a parabola, if the arm is already moving.
_AROUND = 3
#: Smallest speed of a moving marker [arc lengths per second], in addition to the effect of noise.
_SLOWEST = 0.05
#: Latest time of a release after the declared start [s].
_LATEST = 0.3


@dataclass(frozen=True, eq=False)
class Start:
    """The initial state of a motion.

    Attributes:
        sample: index of the first sample that is compared.
        lead: fraction of a sample by which the motion starts before it (a release between two samples).
        pose: (M, 3) marker positions [m]; NaN for a marker that was not measured.
        velocity: (M, 3) marker velocities [m/s].
    """

    sample: int
    lead: float
    pose: Array
    velocity: Array


def start_of(trial: Trial, noise: float, delay: float = 0.0) -> Start:
    """Estimate the state of the markers at a trial's declared start, or ``delay`` [s] after it, without a model.

    A resting arm without an input is held: it starts from its mean position, at the instant at which the markers begin to move.
    An arm that is already moving (after a slow release by hand) starts with the velocity of a parabola through the neighbouring
    samples.

    Args:
        trial: the trial, whose declared start is at or slightly before the release.
        noise: standard deviation of a coordinate [m].
        delay: time after the declared start during which the release may be disturbed [s].
    """
    trajectory = trial.trajectory
    first = min(trial.first_sample + round(delay / trajectory.step), len(trajectory.time) - 1)
    before = trajectory.positions[max(0, first - _WINDOW + 1) : first + 1]
    noise_speed = 5 * noise / (trajectory.step * np.sqrt(max(len(before) * (len(before) ** 2 - 1) / 12, 1e-9)))
    speed = np.linalg.norm(_motion(trajectory, first, before=_WINDOW - 1, after=0, degree=1)[1], axis=1)
    if np.any(speed > max(_SLOWEST * max(marker.arc_length for marker in trajectory.markers), noise_speed)):
        return Start(first, 0.0, *_motion(trajectory, first, before=_AROUND, after=_AROUND, degree=2))
    pose = median(before if np.isfinite(before).any(axis=0).all() else trajectory.positions[first : first + _WINDOW])
    still, lead = np.zeros_like(pose), 0.0
    if not trajectory.has_input:
        begin = _release_time(trajectory, first, pose, noise)
        first = min(int(np.searchsorted(trajectory.time, begin + 1e-9)), len(trajectory.time) - 1)
        lead = float((trajectory.time[first] - begin) / trajectory.step)
    return Start(first, lead, pose, still)


def _motion(trajectory: Trajectory, at: int, before: int, after: int, degree: int) -> tuple[Array, Array]:
    """Return position [m] and velocity [m/s] (M, 3) of each marker at a sample, by a polynomial through neighbouring samples.

    They are NaN and zero for a marker with too few samples.
    """
    window = slice(max(0, at - before), at + after + 1)
    t, shown = trajectory.time[window] - trajectory.time[at], trajectory.positions[window]
    place, velocity = np.full(shown.shape[1:], np.nan), np.zeros(shown.shape[1:])
    for marker in range(shown.shape[1]):
        seen = np.isfinite(shown[:, marker]).all(axis=1)
        if seen.sum() > degree + 1:
            coefficients = np.polyfit(t[seen], shown[seen, marker], degree)
            place[marker], velocity[marker] = coefficients[-1], coefficients[-2]
    return place, velocity


def _release_time(trajectory: Trajectory, first: int, held: Array, noise: float) -> float:
    """Estimate the instant [s] at which an arm in a held pose ``held`` (M, 3) [m] is released.

    After the release the acceleration is constant at first, so the square root of the distance increases linearly; its zero is
    the release. If there is no such line, the time of the sample ``first`` is returned.
    """
    time, positions = trajectory.time, trajectory.positions
    gone = np.linalg.norm(positions - held, axis=2)
    seen = np.isfinite(gone)
    distance = np.where(seen.any(axis=1), np.nanmax(np.where(seen, gone, -np.inf), axis=1), np.nan)
    after = slice(first, min(len(time), first + max(6, round(_LATEST / trajectory.step))))
    if np.isnan(distance[first:]).all():
        return float(time[first])
    d, t = distance[after], time[after]
    threshold = max(8 * noise, 0.01 * float(np.nanmax(distance[first:])))
    moving = np.flatnonzero(d > threshold)
    if not len(moving) or moving[0] + 3 > len(d):
        return float(time[first])
    line = slice(int(moving[0]), int(moving[0]) + 3)
    if not np.isfinite(d[line]).all():
        return float(time[first])
    slope, offset = np.polyfit(t[line], np.sqrt(d[line]), 1)
    return float(np.clip(-offset / slope, time[first], t[line.start])) if slope > 0 else float(time[first])


def median(window: Array) -> Array:
    """Return the median (M, 3) of positions (T, M, 3) over time; NaN for a marker that is never measured."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=RuntimeWarning)  # a marker that is never measured stays NaN
        return np.asarray(np.nanmedian(window, axis=0))
