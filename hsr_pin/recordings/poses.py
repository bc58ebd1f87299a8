"""Conversion of recorded marker orientations into additional points beside the backbone.

A body at a marker turns with its link. Its orientation is represented by two points, along x and y of the link, at the distance
of the arm's surface from the backbone. Simulation and fit can then treat an orientation as two more markers.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence

import numpy as np

from hsr_pin.recordings.text import Table
from hsr_pin.trajectory import Array, Marker

#: Columns of a unit quaternion, real part first.
PARTS = ("qw", "qx", "qy", "qz")
#: Tolerance on the length of a unit quaternion.
UNIT = 0.02


def points_of(posed: Sequence[Marker], radius: float) -> tuple[Marker, ...]:
    """Return two markers for each marker with an orientation: along x and along y of its link, at a distance ``radius`` [m]."""
    return tuple(
        Marker(f"{marker.name}:{axis}", marker.arc_length, abs(place), cmath.phase(place))
        for marker in posed
        for axis, place in (("x", marker.offset + radius), ("y", marker.offset + 1j * radius))
    )


def seen_points(table: Table, posed: Sequence[Marker], radius: float) -> Array:
    """Return the positions (T, 2 M, 3) [m] of these additional points; NaN where position or orientation is missing.

    Raises:
        RecordingError: a quaternion is not of unit length.
    """
    seen = np.empty((len(table.values), 2 * len(posed), 3))
    for k, marker in enumerate(posed):
        fields = [table.place[f"{marker.name}_{part}"] for part in PARTS]
        quaternion = table.values[:, fields]
        size = np.linalg.norm(quaternion, axis=1)
        if np.any(wrong := np.abs(size - 1) > UNIT):
            row, subject = int(np.argmax(wrong)), f"orientation of marker {marker.name}"
            expected, hint = "a quaternion of length 1", "leave the fields empty where the marker was not seen"
            raise table.fault(subject, row, fields[0], expected=expected, received=f"{size[row]:.3g}", hint=hint)
        place = table.values[:, [table.place[f"{marker.name}_{axis}"] for axis in "xyz"]]
        seen[:, 2 * k : 2 * k + 2] = offset_points(place, axes_of(quaternion / size[:, None]), radius)
    return seen


def axes_of(quaternion: Array) -> Array:
    """Return the rotation matrices (T, 3, 3) of unit quaternions (T, 4), real part first; columns are the rotated axes."""
    w, x, y, z = quaternion.T
    columns = [
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(columns), -1, 0).swapaxes(1, 2)


def offset_points(place: Array, axes: Array, radius: float) -> Array:
    """Return the points (T, 2, 3) [m] at a distance ``radius`` from (T, 3) [m] along the first two columns of (T, 3, 3)."""
    return np.asarray(place[:, None] + radius * axes[:, :, :2].swapaxes(1, 2))
