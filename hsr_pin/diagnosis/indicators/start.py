"""Duration of a disturbance after a release, such as a hand that releases slowly, or a payload on a slack thread.

When an arm moves freely towards its equilibrium, the driving force decreases, and so does the acceleration. An acceleration that
increases on the way, or that changes sign and returns, is not that of a free arm. The acceleration is measured along the
direction in which all markers move together, smoothed over a twelfth of a cycle, so that waves along the arm have little
influence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.smooth import smoothed
from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

#: Least significant increase of the acceleration: as a share of its maximum, and in standard errors.
_GROWS, _SURE = 0.35, 5.0
#: The disturbance ends when this share of the increase is reached.
_THERE = 0.9
#: Least acceleration before the release, as a share of the later one, for an arm that was driven before.
_FIRST = 0.5
#: Share of the displacement that is used, because waves along the arm dominate near the equilibrium.
_WAY = 0.7
#: The smoothing window is the time to the first equilibrium crossing divided by this number, with at least this many samples.
_EVEN, _FEWEST = 6, 5


@dataclass(frozen=True)
class Stretch:
    """Duration of a disturbance at the start of a run.

    Attributes:
        seconds: duration since the start of the run [s]; 0 if no disturbance is visible.
        message: what is visible, or why it cannot be determined.
        known: whether the recording can show a disturbance.
    """

    seconds: float
    message: str
    known: bool = True


def start_stretch(run: Run) -> Stretch:
    """Return how long a disturbance acts at the start of a run, from its own acceleration."""
    if run.start_pose is None:
        return Stretch(0.0, "it starts in equilibrium")
    if run.span > 0:
        return Stretch(0.0, "a command moves the arm too, so that other forces cannot be separated", known=False)
    way, noise = _way(run)
    if way is None or not np.ptp(way) > 100 * noise:
        return Stretch(0.0, "the arm hardly moves", known=False)
    rest = float(np.median(way[-max(5, len(way) // 10) :]))
    gone = (way - way[0]) / (rest - way[0])  # 0 at the start, 1 in equilibrium
    passed = np.flatnonzero(gone >= 1)
    if not len(passed) or passed[0] < _FEWEST:
        return Stretch(0.0, "it passes its equilibrium after too few samples", known=False)
    width = max(_FEWEST, int(passed[0] / _EVEN) // 2 * 2 + 1)
    if len(gone) < 2 * width:
        return Stretch(0.0, "the run is too short", known=False)
    push = smoothed(gone, width, 2, deriv=2, step=run.step)[: int(np.flatnonzero(gone >= _WAY)[0]) + 1]
    error = _error(width, run.step) * noise / abs(rest - way[0])
    largest = int(np.argmax(push))
    lowest = np.minimum.accumulate(push)
    growth = push - lowest
    at = int(np.argmax(growth))
    if min(growth[at], push[at]) < max(_GROWS * push[largest], _SURE * error):
        return Stretch(0.0, "it moves freely from the first sample on")
    grown = lowest[at] + _THERE * growth[at]
    back = int(np.flatnonzero(push[: at + 1] < grown)[-1]) + 1
    seconds = float(run.time[min(back, at)] - run.time[0]) + run.lead * run.step
    if lowest[at] < 0 and push[: at + 1].argmin() > 0 and push[: push[: at + 1].argmin()].max() > _FIRST * push[at]:
        message = f"it is driven, released and driven again until {seconds:.2g} s, as by a payload on a slack thread"
    else:
        message = f"the driving force grows until {seconds:.2g} s, unlike that of a free arm, as if a hand releases it slowly"
    return Stretch(seconds, message)


def _way(run: Run) -> tuple[Array | None, float]:
    """Return the displacement (T,) of all markers along the direction of the largest motion, and its noise [m]."""
    seen = np.isfinite(run.tracked).all(axis=(0, 2)) | (np.isfinite(run.tracked).mean(axis=(0, 2)) > 0.8)
    plane = run.tracked[:, seen].reshape(len(run.time), -1)
    if not plane.shape[1]:
        return None, 0.0
    filled = np.stack(
        [np.interp(run.time, run.time[np.isfinite(column)], column[np.isfinite(column)]) for column in plane.T], axis=1
    )
    centred = filled - filled.mean(axis=0)
    direction = np.linalg.svd(centred, full_matrices=False)[2][0]
    way = np.asarray(centred @ direction)
    rough = np.diff(way, 4)
    return way, float(1.4826 * np.median(np.abs(rough)) / np.sqrt(70))


def _error(width: int, step: float) -> float:
    """Return the standard error of an acceleration from a parabola through ``width`` samples with unit noise."""
    t = (np.arange(width) - width // 2) * step
    return float(2 * np.sqrt(np.linalg.inv(np.vander(t, 3).T @ np.vander(t, 3))[0, 0]))
