"""The simulated arm and the frame of its simulation.

Arm frame: origin at the base, z along the straight arm, x towards positive bending; the motion is in this plane. A mount gives
the directions of the two axes in the world (z up).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError

Array = NDArray[np.float64]

#: Mount -> world directions of the arm frame's x and z axes.
MOUNTS: dict[str, tuple[tuple[int, int, int], tuple[int, int, int]]] = {
    "hanging": ((1, 0, 0), (0, 0, -1)),
    "horizontal": ((0, 0, -1), (1, 0, 0)),
    "upright": ((1, 0, 0), (0, 0, 1)),
}


@dataclass(frozen=True)
class Arm:
    """A uniform planar rod, clamped at its base, with attached masses.

    Attributes:
        length: length of the bare arm [m].
        mass: mass of the bare arm [kg].
        diameter: diameter of the bare arm [m].
        mount: a name of `MOUNTS`.
        tip_mass: point mass at the tip [kg].
        added_mass: mass spread evenly along the arm [kg].
        tilt: rotation of the true mount from the declared one, towards positive bending [rad].
        tilt_seen: whether the markers' frame stays with the world (True: the markers show the tilt) or
            rotates with the base (False: only gravity shows the tilt).
        lumps: point masses on the line of the backbone: (distance from the base along the straight arm [m], mass [kg]);
            beyond the tip they are fixed to the last link (chain only).
        wall: distance of a wall parallel to the straight arm, towards +x [m] (chain only), or None.
        g: gravity [m/s2].
    """

    length: float = 0.24
    mass: float = 0.15
    diameter: float = 0.04
    mount: str = "hanging"
    tip_mass: float = 0.0
    added_mass: float = 0.0
    tilt: float = 0.0
    tilt_seen: bool = True
    lumps: tuple[tuple[float, float], ...] = ()
    wall: float | None = None
    g: float = 9.81

    def __post_init__(self) -> None:
        if self.mount not in MOUNTS:
            raise InputError("mount", expected=" or ".join(sorted(MOUNTS)), received=self.mount)

    @property
    def line_mass(self) -> float:
        """Mass per length, including the added mass [kg/m]."""
        return (self.mass + self.added_mass) / self.length

    @property
    def radius(self) -> float:
        """Radius of the arm [m]."""
        return self.diameter / 2

    def gravity(self) -> Array:
        """Return gravity in the arm frame, (2,): x, z [m/s2]."""
        axes = self._axes(self.tilt)
        down = np.array([0.0, 0.0, -self.g])
        return np.array([axes[0] @ down, axes[1] @ down])

    def to_world(self, x: Array, z: Array) -> Array:
        """Return points of the arm frame, each (...), in the frame of the markers, (..., 3) [m]."""
        axes = self._axes(self.tilt if self.tilt_seen else 0.0)
        world: Array = x[..., None] * axes[0] + z[..., None] * axes[1]
        return world

    def _axes(self, tilt: float) -> tuple[Array, Array]:
        ex, ez = (np.array(axis, dtype=float) for axis in MOUNTS[self.mount])
        c, s = np.cos(tilt), np.sin(tilt)
        return c * ex - s * ez, c * ez + s * ex


@dataclass(frozen=True)
class Motion:
    """A planar motion, sampled at nodes along the arm, in the arm frame.

    Attributes:
        t: (T,) times [s].
        s: (N,) arc length of the nodes [m].
        x, z: (T, N) positions of the nodes [m].
        angle: (T, N) direction of the tangent, from the straight arm [rad].
    """

    t: Array
    s: Array
    x: Array
    z: Array
    angle: Array

    def angle_at(self, arc_length: float) -> Array:
        """Return the direction of the tangent at an arc length, (T,) [rad], interpolated linearly between the nodes."""
        k, u, _ = hermite(self.s, arc_length)
        return np.asarray((1 - u) * self.angle[:, k] + u * self.angle[:, k + 1])

    def at(self, arc_length: float, offset: float | Array = 0.0, along: float | Array = 0.0) -> tuple[Array, Array]:
        """Return coordinates x and z, each (T,) [m], of a point next to the backbone, by cubic Hermite interpolation.

        offset: distance from the backbone, towards +x when straight; along: distance along the tangent [m].
        """
        k, _, (h00, h01, h10, h11) = hermite(self.s, arc_length)
        a, b = self.angle[:, k], self.angle[:, k + 1]
        x = h00 * self.x[:, k] + h01 * self.x[:, k + 1] + h10 * np.sin(a) + h11 * np.sin(b)
        z = h00 * self.z[:, k] + h01 * self.z[:, k + 1] + h10 * np.cos(a) + h11 * np.cos(b)
        angle = self.angle_at(arc_length)
        c, s = np.cos(angle), np.sin(angle)
        return x + offset * c + along * s, z - offset * s + along * c


def hermite(s: Array, arc_length: float) -> tuple[int, float, tuple[float, float, float, float]]:
    """Return how a value at an arc length follows from the nodes at arc lengths `s`, by cubic Hermite interpolation.

    Returns:
        index k of the node before it; relative distance to the next node, 0 to 1; weights of the values at the nodes k and
        k + 1, and of their derivatives.
    """
    k = int(np.clip(np.searchsorted(s, arc_length) - 1, 0, s.size - 2))
    h = float(s[k + 1] - s[k])
    u = float(arc_length - s[k]) / h
    return k, u, ((1 + 2 * u) * (1 - u) ** 2, u * u * (3 - 2 * u), u * (1 - u) ** 2 * h, u * u * (u - 1) * h)
