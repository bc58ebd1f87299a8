"""Measures of the tip path of a run: settled position, settling time, overshoot, and distance from a circle.

The path of a planar arm is evaluated in x and z; the path of an arm in space also in the plane nearest to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.robot.space_kinematics import SpaceMarkerMap, space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array, Trajectory

#: The tip has settled when it stays within this share of its total displacement.
BAND = 0.02
#: Share of the time since the step for which the tip must have stayed there; otherwise the run is too short to tell.
STAY = 0.1
#: A tip that moves less than this distance is at rest [m].
STILL = 1e-9


@dataclass(frozen=True)
class Circle:
    """The circle nearest to a path, in the least-squares sense.

    Attributes:
        radius: radius [m]; infinite for a straight line.
        distance: RMS distance of the path from the circle, weighted by path length [m].
    """

    radius: float
    distance: float


@dataclass(frozen=True)
class TipMeasures:
    """Measures of the tip motion after the last change of the command.

    Attributes:
        x, y, z: tip position at the end of the run [m].
        settling_time: time from the last change of the command until the tip stays within 2 % of its displacement [s]; None if it
            does not settle.
        overshoot: overshoot beyond the final position, relative to the displacement [1]; None if the tip does not settle.
        circle: circle nearest to the path of the whole run, for an arm in space within the plane nearest to it; None if the tip
            does not move.
        off_plane: RMS distance of the path from that plane [m]; None for a planar arm.
    """

    x: float
    y: float
    z: float
    settling_time: float | None
    overshoot: float | None
    circle: Circle | None
    off_plane: float | None = None

    @property
    def settled(self) -> bool:
        """Whether the tip is at rest at the end of the run."""
        return self.settling_time is not None


def measure_tip(trajectory: Trajectory, marker: str = "tip") -> TipMeasures:
    """Measure the path of one marker; samples at which the marker was not seen are ignored.

    Raises:
        KeyError: there is no such marker.
    """
    space = trajectory.torque is not None and trajectory.torque.ndim == 2
    whole = trajectory.marker(marker)
    path = whole if space else whole[:, [0, 2]]
    seen = np.isfinite(path).all(axis=1)
    if not seen.any():
        return TipMeasures(np.nan, np.nan, np.nan, None, None, None)
    step = trajectory.time[_last_change(trajectory)]
    after = seen & (trajectory.time >= step)
    settling_time, overshoot = _settling(trajectory.time[after] - step, path[after])
    x, y, z = whole[seen][-1].tolist()
    flat, off_plane = nearest_plane(path[seen]) if space else (path[seen], None)
    return TipMeasures(x, y, z, settling_time, overshoot, nearest_circle(flat), off_plane)


def nearest_plane(path: Array) -> tuple[Array, float]:
    """Return a path (T, 3) [m] projected to the plane nearest to it, (T, 2), and its RMS distance from that plane [m].

    Both are weighted by path length.
    """
    weight = _by_length(path)
    centred = path - np.average(path, axis=0, weights=weight**2)
    axes = np.linalg.svd(weight[:, None] * centred, full_matrices=False)[2]
    return centred @ axes[:2].T, float(np.linalg.norm(weight * (centred @ axes[2])))


def _by_length(path: Array) -> Array:
    """Return the square roots (T,) of the shares of the path length that the points represent.

    For a path of zero length the shares are equal.
    """
    pieces = np.linalg.norm(np.diff(path, axis=0), axis=1)
    whole = pieces.sum()
    if whole < STILL:
        return np.full(len(path), 1 / np.sqrt(len(path)))
    return np.asarray(np.sqrt((np.append(pieces, 0.0) + np.append(0.0, pieces)) / (2 * whole)))


def nearest_circle(path: Array) -> Circle | None:
    """Return the circle nearest to a path (T, 2) [m], of infinite radius for a straight line; None for a single point.

    The distance of a point from a curve that crosses the second principal axis of the path at ``offset``, with the direction
    ``turn`` and the curvature ``bend``, is q / (1 + sqrt(1 + bend q)), q = bend |w|^2 - 2 w.n. This form is regular where circles
    become lines.
    """
    if np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < STILL:
        return None
    weight = _by_length(path)
    centred = path - np.average(path, axis=0, weights=weight**2)
    _, extent, axes = np.linalg.svd(weight[:, None] * centred, full_matrices=False)
    scale = float(extent[0])
    points = centred @ axes.T / scale

    fits = [_fitted(points, weight, bend) for bend in (0.0, 1.0, -1.0)]
    distance, bend = min(fits)
    return Circle(radius=scale / abs(bend) if bend else np.inf, distance=scale * distance)


def _fitted(points: Array, weight: Array, bend: float) -> tuple[float, float]:
    """Fit a circle by Gauss-Newton steps with halving; return the distance and the curvature.

    SciPy's least-squares solver gives the same result (tested), but loading it would take as long as the rest of ``hsr-sim``.
    """
    curve = np.array([bend, 0.0, 0.0])
    miss, slopes = _distances(points, weight, curve)
    for _ in range(100):
        step = -np.linalg.lstsq(slopes, miss, rcond=None)[0]
        while np.linalg.norm(step) > 1e-12:
            new, new_slopes = _distances(points, weight, curve + step)
            if new @ new <= miss @ miss:
                break
            step /= 2
        else:
            break
        curve, miss, slopes = curve + step, new, new_slopes
    return float(np.linalg.norm(miss)), float(curve[0])


def _distances(points: Array, weight: Array, curve: Array) -> tuple[Array, Array]:
    """Return weighted distances (T,) of points (T, 2) from a curve (bend, turn, offset), and their derivatives (T, 3)."""
    bend, turn, offset = curve
    normal, along = np.array([-np.sin(turn), np.cos(turn)]), np.array([np.cos(turn), np.sin(turn)])
    w = points - np.array([0.0, offset])
    q = bend * (w * w).sum(axis=1) - 2 * w @ normal
    root = np.sqrt(np.maximum(1 + bend * q, 1e-12))
    distance = q / (1 + root)
    by_curve = (
        np.column_stack([(w * w).sum(axis=1) - distance**2, 2 * w @ along, 2 * (normal[1] - bend * w[:, 1])])
        / (2 * root)[:, None]
    )
    return weight * distance, weight[:, None] * by_curve


def _last_change(trajectory: Trajectory) -> int:
    """Return the index of the last sample at which the command changes; 0 if it never changes."""
    command = trajectory.torque if trajectory.pressures is None else trajectory.pressures
    if command is None:
        return 0
    changed = np.diff(command.reshape(len(command), -1), axis=0).any(axis=1)
    return int(np.flatnonzero(changed)[-1]) + 1 if changed.any() else 0


def _settling(elapsed: Array, path: Array) -> tuple[float | None, float | None]:
    """Return settling time [s] and overshoot [1] of a path (T, 2) after a command at time 0; (None, None) if unsettled."""
    if len(path) < 2:
        return None, None
    way = path[-1] - path[0]
    whole = float(np.linalg.norm(way))
    farthest = float(np.linalg.norm(path - path[0], axis=1).max())
    if farthest < STILL:
        return 0.0, 0.0
    distance = np.linalg.norm(path - path[-1], axis=1)
    outside = np.flatnonzero(distance > BAND * whole)
    time = _crossing(elapsed, distance, int(outside[-1]), BAND * whole) if len(outside) else 0.0
    if time > (1 - STAY) * elapsed[-1]:
        return None, None
    overshoot = float(((path - path[0]) @ way).max()) / whole**2 - 1 if whole > 0 else 0.0
    return time, max(0.0, overshoot)


def _crossing(elapsed: Array, distance: Array, last: int, band: float) -> float:
    """Return the time [s] at which the distance, interpolated linearly, falls to ``band`` after the sample ``last``."""
    before, after = distance[last : last + 2]
    share = (before - band) / (before - after)
    return float(elapsed[last] + share * (elapsed[last + 1] - elapsed[last]))


def first_self_contact(arm: ArmSpecification, motion: Trajectory) -> float | None:
    """Return the time [s] at which an arm of its diameter first touches itself in a simulated motion; None if it never does.

    Points of the backbone that are closer along the arm than two diameters are not compared.
    """
    assert motion.joint_angles is not None
    places = np.linspace(0, arm.length, max(2, round(4 * arm.length / arm.diameter)) + 1)
    points: MarkerMap | SpaceMarkerMap = (space_marker_map if arm.bending == "space" else marker_map)(arm, places)
    positions = points.positions(motion.joint_angles.reshape(len(motion.time), -1))
    first, second = np.nonzero(np.subtract.outer(places, places) > 2 * arm.diameter)
    near = np.linalg.norm(positions[:, first] - positions[:, second], axis=2).min(axis=1, initial=np.inf) < arm.diameter
    return float(motion.time[np.argmax(near)]) if near.any() else None
