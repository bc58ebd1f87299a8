"""The simulated arm in space, its frame (as in the plane, completed by y), and its motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arm import MOUNTS, Arm, Array, hermite


@dataclass(frozen=True)
class SpaceArm(Arm):
    """An arm that bends about two axes.

    Attributes:
        side_tilt: tilt of the true mount towards y [rad]; with ``tilt`` it is one rotation about an axis across the arm.
    """

    side_tilt: float = 0.0

    def gravity(self) -> Array:
        """Return gravity in the arm frame, (3,) [m/s2]."""
        return np.asarray(self.frame(seen=False).T @ np.array([0.0, 0.0, -self.g]))

    def frame(self, *, seen: bool) -> Array:
        """Return the arm's axes in the world, (3, 3), or, if ``seen``, as the markers' frame shows them."""
        x, z = (np.array(axis, dtype=float) for axis in MOUNTS[self.mount])
        mounted = np.column_stack([x, np.cross(z, x), z])
        if seen and not self.tilt_seen:
            return mounted
        return np.asarray(mounted @ turned(np.array([-self.side_tilt, self.tilt, 0.0])))


class SpaceNodes(NamedTuple):
    """Points along the backbone: position (3, N) [m], velocity of the last (3, 1) [m/s], axes (N, 3, 3); angles are unused."""

    position: Array
    velocity: Array
    frames: Array
    angle: Array


@dataclass(frozen=True)
class SpaceMotion:
    """A motion in space, sampled at nodes along the arm, in the arm frame.

    Attributes:
        t: (T,) times [s].
        s: (N,) arc length of the nodes [m].
        position: (T, 3, N) positions of the nodes [m].
        frames: (T, N, 3, 3) axes of the cross sections, z along the arm.
    """

    t: Array
    s: Array
    position: Array
    frames: Array

    def at(self, arc_length: float, beside: complex = 0.0, along: float = 0.0) -> Array:
        """Return a point (T, 3) [m] at an offset x + i y of the section from the backbone, by cubic Hermite interpolation."""
        k, u, (h00, h01, h10, h11) = hermite(self.s, arc_length)
        a, b = self.frames[:, k], self.frames[:, k + 1]
        place = h00 * self.position[..., k] + h01 * self.position[..., k + 1] + h10 * a[..., 2] + h11 * b[..., 2]
        between = (1 - u) * a + u * b
        between = between / np.linalg.norm(between, axis=1, keepdims=True)
        return np.asarray(place + between @ np.array([np.real(beside), np.imag(beside), along]))


def moving(t: Array, s: Array, nodes: Sequence[SpaceNodes]) -> SpaceMotion:
    """Return the motion from the nodes at each sample."""
    return SpaceMotion(t, s, np.stack([each.position for each in nodes]), np.stack([each.frames for each in nodes]))


def turned(w: Array) -> Array:
    """Return the rotation matrix (3, 3) of a rotation vector (3,) [rad]."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(w).as_matrix())
