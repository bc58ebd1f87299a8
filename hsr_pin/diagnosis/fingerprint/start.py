"""How long something else still acts after a release: a hand that lets go slowly, a payload whose thread is slack.

Once an arm is free, and as long as it has not passed its place of rest, the force that drives it there falls: so does the
acceleration. An acceleration that grows on the way, or that turns against the way and comes back, is no free arm's. What is
looked at is the one direction in which all markers move together, evened out over a twelfth of a swing, so that waves along the
arm weigh little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.smooth import smoothed
from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

#: The acceleration must grow by this share of its largest on the way to rest, and be this many standard errors sure of it.
_GROWS, _SURE = 0.35, 5.0
#: It is over once this share of the largest acceleration is reached.
_THERE = 0.9
#: It was driven before it was let go if it was by this share of that.
_FIRST = 0.5
#: Share of the way to rest that is looked at: near the place of rest waves along the arm are all there is.
_WAY = 0.7
#: Part of half a swing over which the motion is evened out, and the fewest samples.
_EVEN, _FEWEST = 6, 5


@dataclass(frozen=True)
class Stretch:
    """How long something else acts at the start of a run.

    Attributes:
        seconds: from the start of the run on; 0 where nothing is seen.
        word: what is seen, or why it cannot be told.
        told: whether the recording can tell.
    """

    seconds: float
    word: str
    told: bool = True


def start_stretch(run: Run) -> Stretch:
    """How long something else still acts at the start of a run that starts from a pose, by its own acceleration."""
    if run.start_pose is None:
        return Stretch(0.0, "it starts settled")
    if run.span > 0:
        return Stretch(0.0, "a command moves the arm as well: this cannot tell what else does", told=False)
    way, noise = _way(run)
    if way is None or not np.ptp(way) > 100 * noise:
        return Stretch(0.0, "the arm hardly moves", told=False)
    rest = float(np.median(way[-max(5, len(way) // 10) :]))
    gone = (way - way[0]) / (rest - way[0])  # 0 at the start, 1 at rest
    passed = np.flatnonzero(gone >= 1)
    if not len(passed) or passed[0] < _FEWEST:
        return Stretch(0.0, "it passes its place of rest after too few samples", told=False)
    width = max(_FEWEST, int(passed[0] / _EVEN) // 2 * 2 + 1)
    if len(gone) < 2 * width:
        return Stretch(0.0, "too short", told=False)
    push = smoothed(gone, width, 2, deriv=2, step=run.step)[: int(np.flatnonzero(gone >= _WAY)[0]) + 1]
    error = _error(width, run.step) * noise / abs(rest - way[0])
    largest = int(np.argmax(push))
    lowest = np.minimum.accumulate(push)
    growth = push - lowest
    at = int(np.argmax(growth))
    if min(growth[at], push[at]) < max(_GROWS * push[largest], _SURE * error):
        return Stretch(0.0, "from the first sample on it moves as a free arm does")
    grown = lowest[at] + _THERE * growth[at]
    back = int(np.flatnonzero(push[: at + 1] < grown)[-1]) + 1
    seconds = float(run.time[min(back, at)] - run.time[0]) + run.lead * run.step
    if lowest[at] < 0 and push[: at + 1].argmin() > 0 and push[: push[: at + 1].argmin()].max() > _FIRST * push[at]:
        word = f"it is driven, let go and driven again until {seconds:.2g} s: as by a payload that was slack"
    else:
        word = f"what drives it grows until {seconds:.2g} s, where that of a free arm falls: as under a hand that lets go slowly"
    return Stretch(seconds, word)


def _way(run: Run) -> tuple[Array | None, float]:
    """(T,) [m] of all markers together along the direction in which they move most, and the noise in it [m]."""
    seen = np.isfinite(run.tracked).all(axis=(0, 2)) | (np.isfinite(run.tracked).mean(axis=(0, 2)) > 0.8)
    plane = run.tracked[:, seen].reshape(len(run.time), -1)
    if not plane.shape[1]:
        return None, 0.0
    filled = np.stack(
        [np.interp(run.time, run.time[np.isfinite(column)], column[np.isfinite(column)]) for column in plane.T], axis=1
    )
    apart = filled - filled.mean(axis=0)
    direction = np.linalg.svd(apart, full_matrices=False)[2][0]
    way = np.asarray(apart @ direction)
    rough = np.diff(way, 4)
    return way, float(1.4826 * np.median(np.abs(rough)) / np.sqrt(70))


def _error(width: int, step: float) -> float:
    """Standard error of an acceleration from a parabola through so many samples, for noise of one."""
    t = (np.arange(width) - width // 2) * step
    return float(2 * np.sqrt(np.linalg.inv(np.vander(t, 3).T @ np.vander(t, 3))[0, 0]))
