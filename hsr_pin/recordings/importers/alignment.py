"""Alignment of the laboratory's frame with the arm's: z up, origin at the base, bending in the x-z plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.clean import moving_average
from hsr_pin.recordings.importers.capture import seen
from hsr_pin.trajectory import Array

#: Share and smallest number of the straightest frames, whose median is the straight pose.
STRAIGHTEST, FEWEST = 0.02, 5
#: Number of frames over which the reach is smoothed, so that noise does not determine the selection.
SMOOTH = 11
#: Smallest RMS motion perpendicular to the arm that determines a plane [m].
STILL = 2e-4
#: Smallest cosine of the angle between a vertical arm and the vertical, and largest one of a horizontal arm.
VERTICAL, HORIZONTAL = 0.8, 0.5


@dataclass(frozen=True, eq=False)
class Alignment:
    """Position and orientation of the arm's frame in the laboratory.

    Attributes:
        origin: (3,) position of the base [m].
        rotation: (3, 3) matrix whose rows are the arm's axes x, y, z in laboratory coordinates.
    """

    origin: Array
    rotation: Array

    def to_world(self, positions: Array) -> Array:
        """Return laboratory coordinates (..., 3) in the arm's frame."""
        return np.asarray((positions - self.origin) @ self.rotation.T)


def straightest(captures: Sequence[Array], stretch: Sequence[Array]) -> NDArray[np.intp]:
    """Return the frames (F,), counted through all captures, with the longest reach, in which the arm is straightest.

    Args:
        captures: (T, B, 3) positions of each capture, without spikes.
        stretch: (T,) for each capture, a length that is largest when the arm is straight [m]; NaN where unknown.

    Raises:
        RecordingError: no frame shows all bodies.
    """
    poses = np.concatenate(captures)
    reach = np.concatenate([moving_average(values[:, None, None], SMOOTH)[:, 0, 0] for values in stretch])
    usable = np.isfinite(poses).all(axis=(1, 2)) & np.isfinite(reach)
    if not usable.any():
        raise RecordingError("no frame shows all markers", hint="choose fewer markers with --marker")
    reach = reach[usable]
    count = min(len(reach), max(FEWEST, int(STRAIGHTEST * len(reach))))
    return np.flatnonzero(usable)[np.argsort(reach)[-count:]]


def mount_of(direction: Array, up: Array) -> str:
    """Return the mount of an arm from its direction and the direction up, both unit vectors (3,).

    Raises:
        InputError: the arm is neither vertical nor horizontal.
    """
    slope = float(direction @ up)
    if abs(slope) >= VERTICAL:
        return "upright" if slope > 0 else "hanging"
    if abs(slope) <= HORIZONTAL:
        return "horizontal"
    raise InputError(
        "mount",
        expected="an arm that is vertical or horizontal when straight",
        received=f"{np.degrees(np.arcsin(slope)):.0f} deg above the horizontal",
        hint="give the axis that is up with --up, or the mount with --mount",
    )


def across(up: Array) -> Array:
    """Return two orthogonal directions (2, 3) perpendicular to ``up``, the second a quarter turn ahead of the first."""
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first)])


def bending_direction(captures: Sequence[Array], up: Array) -> Array | None:
    """Return the direction (3,) of largest motion perpendicular to ``up``, of either sign; None without motion.

    Each body's motion is taken about its own median, so that markers may stand off the plane.

    Args:
        captures: (T, B, 3) positions [m] of the moving bodies in each capture, without spikes.
        up: (3,) unit vector that points up.
    """
    plane = across(up)
    bodies = [values[seen(values)] for positions in captures for values in positions.swapaxes(0, 1)]
    motion = [(values - np.median(values, axis=0)) @ plane.T for values in bodies if len(values)]
    flat = np.concatenate(motion) if motion else np.empty((0, 2))
    if len(flat) < 2:
        return None
    _, sizes, directions = np.linalg.svd(flat, full_matrices=False)
    if sizes[0] / np.sqrt(len(flat)) < STILL:
        return None
    return np.asarray(directions[0] @ plane)


def frame(origin: Array, x: Array, up: Array) -> Alignment:
    """Return the right-handed frame with z up and the x axis nearest to ``x``."""
    x = x - (x @ up) * up
    x /= np.linalg.norm(x)
    return Alignment(origin, np.stack([x, np.cross(up, x), up]))
