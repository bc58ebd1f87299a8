"""Obstacles of an exported model as solids of the formats."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hsr_pin.export.model import CorrectedModel
from hsr_pin.obstacles import CYLINDER, FRICTION, HALF_SPACE, SPHERE
from hsr_pin.trajectory import Array

#: Cosine of the pitch below which only the sum or the difference of roll and yaw is known within rounding.
LOCKED = 1e-9
#: Length of an infinite cylinder, and edge and thickness of the plate for a half space, relative to the length of the arm.
_LONG, _WIDE, _THICK = 4.0, 8.0, 0.5


@dataclass(frozen=True)
class Solid:
    """An obstacle in the frame of the base.

    Attributes:
        name: its name.
        kind: "sphere", "cylinder" (along z) or "box".
        size: radius and length, or the edges [m].
        centre: position [m].
        rpy: roll, pitch and yaw [rad].
        friction: coefficient of friction.
    """

    name: str
    kind: str
    size: tuple[float, ...]
    centre: tuple[float, float, float]
    rpy: tuple[float, float, float]
    friction: float

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Quaternion (w, x, y, z): Rz(yaw) Ry(pitch) Rx(roll)."""
        return quaternion(self.rpy)


def quaternion(rpy: tuple[float, float, float]) -> tuple[float, float, float, float]:
    """Return the quaternion (w, x, y, z) of roll, pitch and yaw [rad]: Rz(yaw) Ry(pitch) Rx(roll)."""
    (a, b), (c, s), (e, f) = ((math.cos(angle / 2), math.sin(angle / 2)) for angle in rpy)
    return c * a * e + s * b * f, c * b * e - s * a * f, s * a * e + c * b * f, c * a * f - s * b * e


def solids_of(model: CorrectedModel) -> tuple[Solid, ...]:
    """Return the obstacles of the arm and of its effects; a half space is a thick plate, and an infinite cylinder a long one."""
    rows, length, found = model.batch.world[0], model.arm.length, []
    # the base of an export has x towards positive bending and z along the arm, like an arm in space
    turn = np.eye(3) if model.batch.space else np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    for number, row in enumerate(rows, 1):
        centre, axes = turn @ row[1:4], turn @ row[4:13].reshape(3, 3).T
        kind, size = _solid(int(row[0]), row[13:16], length)
        if row[0] == HALF_SPACE:
            centre = centre - axes[:, 2] * size[2] / 2
        rpy = angles_of(axes)
        place = (float(centre[0]), float(centre[1]), float(centre[2]))
        found.append(Solid(f"obstacle_{number}", kind, size, place, rpy, float(row[FRICTION])))
    return tuple(found)


def angles_of(turn: Array) -> tuple[float, float, float]:
    """Return roll, pitch and yaw [rad] of a rotation matrix (3, 3); the yaw is 0 if a pitch of a quarter turn leaves it open."""
    x, y, z = turn.T
    level = math.hypot(x[0], x[1])
    pitch = math.atan2(-x[2], level)
    if level < LOCKED:
        return math.atan2(-z[1], y[1]), pitch, 0.0
    return math.atan2(y[2], z[2]), pitch, math.atan2(x[1], x[0])


def _solid(kind: int, size: Array, length: float) -> tuple[str, tuple[float, ...]]:
    """Return the word and the dimensions of a solid for an obstacle beside an arm of a length [m]."""
    if kind == HALF_SPACE:
        return "box", (_WIDE * length, _WIDE * length, _THICK * length)
    if kind == SPHERE:
        return "sphere", (float(size[0]),)
    if kind == CYLINDER:
        return "cylinder", (float(size[0]), min(2 * float(size[1]), _LONG * length))
    return "box", tuple(2 * float(edge) for edge in size)
