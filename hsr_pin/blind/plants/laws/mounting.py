"""Laws of masses, mounting and markers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arm import Arm, Array
from ..program import Trial
from .law import Law, one_of, strength


@dataclass(frozen=True)
class GravityTilt(Law, name="gravity_tilt"):
    """Tilt of the base from its declared mounting.

    The base is rotated in the plane (robot-to-world calibration: B. Siciliano, O. Khatib, eds., Springer
    Handbook of Robotics, 2nd ed., ch. 6).

    form ``mount``: the base is rotated in the world, and the markers show it; ``frame``: the markers'
    frame rotates with it, so that only gravity shows the tilt.

    angle: towards positive bending [rad].
    """

    angle: float = strength(0.05, limit=0.6, signed=True)
    form: str = one_of("mount", "frame")

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        seen = arm.tilt_seen and self.form == "mount"
        return replace(arm, tilt=arm.tilt + self.angle, tilt_seen=seen)


@dataclass(frozen=True)
class TipMass(Law, name="tip_mass"):
    """An unknown point mass at the tip (D. J. Inman, Engineering Vibration, ch. 6).

    mass: [kg].
    """

    mass: float = strength(0.015, limit=0.2)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, tip_mass=arm.tip_mass + self.mass)


@dataclass(frozen=True)
class AddedMass(Law, name="added_mass"):
    """Mass without stiffness, evenly spread along the arm, such as tubes.

    mass: [kg].
    """

    mass: float = strength(0.04, limit=0.3)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, added_mass=arm.added_mass + self.mass)


@dataclass(frozen=True)
class MarkerOffset(Law, name="marker_offset"):
    """Offset of the markers from the neutral line.

    Markers are mounted off the neutral line on plates that rotate with the arm (U. Della Croce et al., Human
    Movement Analysis Using Stereophotogrammetry, part 4, Gait & Posture 21, 2005).

    distance: towards +x of the straight arm [m].
    """

    distance: float = strength(0.004, limit=0.04, signed=True)

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return np.zeros_like(angle), np.full_like(angle, self.distance)
