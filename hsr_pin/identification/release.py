"""How a motion starts that does not start at rest under its input: the pose the markers show, and the instant of release."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import ArmModel
from hsr_pin.trajectory import Array, Trial

#: Samples before the start over which the held pose is averaged.
_WINDOW = 5
#: A release is looked for within this time after the declared start [s].
_LATEST = 0.3


def held_pose(trial: Trial) -> Array:
    """(M, 3) [m] where the markers are at the start: the median over the last samples up to it."""
    first = trial.first_sample
    window = trial.trajectory.positions[max(0, first - _WINDOW + 1) : first + 1]
    return _median(window if np.isfinite(window).any(axis=0).all() else trial.trajectory.positions[first : first + _WINDOW])


def release_time(trial: Trial, noise: float) -> float:
    """The instant [s] at which a held arm is let go, as its markers show it.

    After the release the arm accelerates evenly at first, so that the root of the distance gone grows as a straight line; its
    zero is the release. Nothing of a model is used. The declared start is given back where no such line is found.

    Args:
        trial: whose declared start is at or a little before the release.
        noise: standard deviation of a coordinate [m].
    """
    time, positions = trial.trajectory.time, trial.trajectory.positions
    first = trial.first_sample
    gone = np.linalg.norm(positions - held_pose(trial), axis=2)
    seen = np.isfinite(gone)
    distance = np.where(seen.any(axis=1), np.nanmax(np.where(seen, gone, -np.inf), axis=1), np.nan)
    after = slice(first, min(len(time), first + max(6, round(_LATEST / trial.trajectory.step))))
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


def pose_from_markers(arm: ArmModel, arc_lengths: Array, positions: Array, noise: float = 1e-3) -> Array:
    """Joint angles (N,) [rad] of the smoothest bent arm that puts its markers where they were seen.

    Curvature along the arm is a sum of Legendre polynomials, as many as the markers can tell; a weak penalty on the higher ones
    keeps noise out of them.

    Args:
        arm: the chain.
        arc_lengths: (M,) [m] of the markers.
        positions: (M, 3) [m]; NaN where not seen.
        noise: of a coordinate [m].
    """
    seen = np.isfinite(positions).all(axis=1) & (arc_lengths > 0.02 * arm.specification.length)
    modes = min(2 * int(seen.sum()), 4, arm.specification.links)
    if modes == 0:
        return np.zeros(arm.specification.links)
    s = 2 * arm.specification.element_arc_lengths - 1
    shapes = np.polynomial.legendre.legvander(s, modes - 1) / arm.specification.links
    places = marker_map(arm, arc_lengths[seen])
    stiffness = 1e-3 * 4.0 ** np.arange(modes)

    def residual(curvature: Array) -> Array:
        miss = (places.positions(shapes @ curvature) - positions[seen]) / max(noise, 1e-4)
        return np.concatenate([miss.ravel(), stiffness * curvature])

    return np.asarray(shapes @ least_squares(residual, np.zeros(modes), method="lm").x)


def _median(window: Array) -> Array:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", category=RuntimeWarning)  # a marker that is never seen stays NaN
        return np.asarray(np.nanmedian(window, axis=0))
