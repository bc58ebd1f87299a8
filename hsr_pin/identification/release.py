"""How a motion starts that does not start at rest under its input: where the markers are then, how fast, and when it begins."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array, Trajectory, Trial

#: Samples up to the start over which the held pose is averaged, and by which it is told whether the arm is held at all.
_WINDOW = 5
#: Samples on either side of the start through which a parabola is laid where the arm is moving already.
_AROUND = 3
#: The arm is moving if a marker goes faster than this [arc lengths per second], beyond what noise makes of a resting one.
_SLOWEST = 0.05
#: A release is looked for within this time after the declared start [s].
_LATEST = 0.3


@dataclass(frozen=True, eq=False)
class Start:
    """Where a motion is followed from.

    Attributes:
        sample: the first that is compared.
        lead: fraction of a sample by which the motion starts before it (a release between two samples).
        pose: (M, 3) [m] of the markers; NaN for one that is not seen.
        velocity: (M, 3) [m/s] of the markers.
    """

    sample: int
    lead: float
    pose: Array
    velocity: Array


def start_of(trial: Trial, noise: float, delay: float = 0.0) -> Start:
    """The state of the markers at a trial's declared start, or ``delay`` [s] after it; nothing of a model is used.

    A still arm without an input is held: it starts from its mean place, at the instant at which the markers begin to move. An arm
    that moves already (a hand that lets go slowly) starts with the velocity of the parabola through the samples around.

    Args:
        trial: whose declared start is at or a little before the release.
        noise: standard deviation of a coordinate [m].
        delay: a hand may touch the arm for so long after the declared start [s].
    """
    trajectory = trial.trajectory
    first = min(trial.first_sample + round(delay / trajectory.step), len(trajectory.time) - 1)
    before = trajectory.positions[max(0, first - _WINDOW + 1) : first + 1]
    sure = 5 * noise / (trajectory.step * np.sqrt(max(len(before) * (len(before) ** 2 - 1) / 12, 1e-9)))
    speed = np.linalg.norm(_motion(trajectory, first, before=_WINDOW - 1, after=0, degree=1)[1], axis=1)
    if np.any(speed > max(_SLOWEST * max(marker.arc_length for marker in trajectory.markers), sure)):
        return Start(first, 0.0, *_motion(trajectory, first, before=_AROUND, after=_AROUND, degree=2))
    pose = median(before if np.isfinite(before).any(axis=0).all() else trajectory.positions[first : first + _WINDOW])
    still, lead = np.zeros_like(pose), 0.0
    if not trajectory.has_input:
        begin = _release_time(trajectory, first, pose, noise)
        first = min(int(np.searchsorted(trajectory.time, begin + 1e-9)), len(trajectory.time) - 1)
        lead = float((trajectory.time[first] - begin) / trajectory.step)
    return Start(first, lead, pose, still)


def _motion(trajectory: Trajectory, at: int, before: int, after: int, degree: int) -> tuple[Array, Array]:
    """Place [m] and velocity [m/s] (M, 3) of each marker at a sample, by the polynomial through some samples around it.

    NaN and zero for a marker that is seen too seldom.
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
    """The instant [s] at which an arm held in a place ``held`` (M, 3) [m] is let go, as its markers show it.

    After the release the arm accelerates evenly at first, so that the root of the distance gone grows as a straight line; its
    zero is the release. The sample ``first`` is given back where no such line is found.
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
    """(M, 3) of positions (T, M, 3) over time; NaN for a marker that is never seen."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=RuntimeWarning)  # a marker that is never seen stays NaN
        return np.asarray(np.nanmedian(window, axis=0))
