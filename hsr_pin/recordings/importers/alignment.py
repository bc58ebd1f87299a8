"""From the laboratory's frame to the arm's: z up, origin at the base, bending in the x-z plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.clean import moving_average
from hsr_pin.recordings.importers.capture import seen
from hsr_pin.trajectory import Array

#: Share of the frames, the straightest ones, that the straight pose is the median of; and at least so many frames.
STRAIGHTEST, FEWEST = 0.02, 5
#: The reach is smoothed over so many frames first, lest noise choose the frames.
SMOOTH = 11
#: Less motion across the arm than this [m, root mean square] shows no plane.
STILL = 2e-4
#: The arm is held to be vertical within this angle's cosine of it, horizontal within the sine.
VERTICAL, HORIZONTAL = 0.8, 0.5


@dataclass(frozen=True, eq=False)
class Alignment:
    """Where the arm's frame stands in the laboratory's.

    Attributes:
        origin: (3,) [m] the base.
        rotation: (3, 3) its rows are the arm's axes x, y, z in laboratory coordinates.
    """

    origin: Array
    rotation: Array

    def to_world(self, positions: Array) -> Array:
        """(..., 3) laboratory coordinates in the arm's frame."""
        return np.asarray((positions - self.origin) @ self.rotation.T)


def straightest(captures: Sequence[Array], stretch: Sequence[Array]) -> NDArray[np.intp]:
    """(F,) the frames, counted through all captures, in which the arm is straightest: those of the longest reach.

    Args:
        captures: (T, B, 3) each, without spikes.
        stretch: (T,) each, what is largest when the arm is straight [m]; NaN where unknown.

    Raises:
        RecordingError: no frame shows all bodies.
    """
    poses = np.concatenate(captures)
    reach = np.concatenate([moving_average(values[:, None, None], SMOOTH)[:, 0, 0] for values in stretch])
    usable = np.isfinite(poses).all(axis=(1, 2)) & np.isfinite(reach)
    if not usable.any():
        raise RecordingError("no frame shows all markers", hint="choose fewer with --marker")
    reach = reach[usable]
    count = min(len(reach), max(FEWEST, int(STRAIGHTEST * len(reach))))
    return np.flatnonzero(usable)[np.argsort(reach)[-count:]]


def mount_of(direction: Array, up: Array) -> str:
    """The mount of an arm that points in a direction (both (3,), of unit length).

    Raises:
        InputError: neither vertical nor horizontal.
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
        hint="say which axis is up with --up, or the mount with --mount",
    )


def across(up: Array) -> Array:
    """(2, 3) two directions at right angles to ``up`` and to each other, the second a quarter turn ahead of the first."""
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first)])


def bending_direction(captures: Sequence[Array], up: Array) -> Array | None:
    """(3,) the direction at right angles to ``up`` in which bodies move most, of either sign; None if they do not move.

    Each body's motion is taken about its own median, so that markers may stand off the plane.

    Args:
        captures: (T, B, 3) each [m], moving bodies without spikes.
        up: (3,).
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
    """The right-handed frame with z up and x as near to ``x`` as that allows."""
    x = x - (x @ up) * up
    x /= np.linalg.norm(x)
    return Alignment(origin, np.stack([x, np.cross(up, x), up]))
