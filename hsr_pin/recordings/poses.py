"""Markers whose orientation is recorded: it is followed as points beside the backbone, which every room can compare.

A body at a marker turns with its link. Where its axes point, towards x and y of the link, two more points are seen, as far from
the backbone as the arm's surface.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence

import numpy as np

from hsr_pin.recordings.text import Table
from hsr_pin.trajectory import Array, Marker

#: Columns of a unit quaternion, its real part first.
PARTS = ("qw", "qx", "qy", "qz")
#: A quaternion is that of a rotation where its length is one within this.
UNIT = 0.02


def points_of(posed: Sequence[Marker], radius: float) -> tuple[Marker, ...]:
    """Two points for each marker with an orientation: towards x and towards y of its link, ``radius`` [m] from it."""
    return tuple(
        Marker(f"{marker.name}:{axis}", marker.arc_length, abs(place), cmath.phase(place))
        for marker in posed
        for axis, place in (("x", marker.beside + radius), ("y", marker.beside + 1j * radius))
    )


def seen_points(table: Table, posed: Sequence[Marker], radius: float) -> Array:
    """(T, 2 M, 3) [m] where these points are seen; NaN where the place or the orientation is not.

    Raises:
        RecordingError: numbers that are no rotation.
    """
    seen = np.empty((len(table.values), 2 * len(posed), 3))
    for k, marker in enumerate(posed):
        fields = [table.place[f"{marker.name}_{part}"] for part in PARTS]
        quaternion = table.values[:, fields]
        size = np.linalg.norm(quaternion, axis=1)
        if np.any(wrong := np.abs(size - 1) > UNIT):
            row, said = int(np.argmax(wrong)), f"orientation of marker {marker.name}"
            hint = "one that was not seen has empty fields"
            raise table.fault(said, row, fields[0], expected="length 1", received=f"{size[row]:.3g}", hint=hint)
        place = table.values[:, [table.place[f"{marker.name}_{axis}"] for axis in "xyz"]]
        seen[:, 2 * k : 2 * k + 2] = beside(place, axes_of(quaternion / size[:, None]), radius)
    return seen


def axes_of(quaternion: Array) -> Array:
    """(T, 3, 3) the rotations of unit quaternions (T, 4), their real parts first: columns are where x, y and z point."""
    w, x, y, z = quaternion.T
    columns = [
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(columns), -1, 0).swapaxes(1, 2)


def beside(place: Array, axes: Array, radius: float) -> Array:
    """(T, 2, 3) [m] the two points of a body at (T, 3) [m] whose x and y point along the first columns of (T, 3, 3) axes."""
    return np.asarray(place[:, None] + radius * axes[:, :, :2].swapaxes(1, 2))
