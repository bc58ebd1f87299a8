"""Laws of masses, mounting and markers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from hsr_pin.errors import EffectError

from ..arm import Arm, Array
from ..program import Trial
from .law import Law, sign


@dataclass(frozen=True)
class GravityTilt(Law):
    """Tilt of the base from its declared mounting.

    The base is rotated in the plane (robot-to-world calibration: B. Siciliano, O. Khatib, eds., Springer
    Handbook of Robotics, 2nd ed., ch. 6).

    form ``mount``: the base is rotated in the world, and the markers show it; ``frame``: the markers'
    frame rotates with it, so that only gravity shows the tilt.

    angle: towards positive bending [rad].
    """

    name: ClassVar[str] = "gravity_tilt"
    strength: ClassVar[str] = "angle"
    limit: ClassVar[float] = 0.6
    angle: float = 0.0
    form: str = "mount"

    def __post_init__(self) -> None:
        if self.form not in ("mount", "frame"):
            raise EffectError("gravity_tilt form", expected="mount or frame", received=self.form)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> GravityTilt:
        return cls(0.05 * sign(rng), str(rng.choice(["mount", "frame"])))

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        seen = arm.tilt_seen and self.form == "mount"
        return replace(arm, tilt=arm.tilt + self.angle, tilt_seen=seen)


@dataclass(frozen=True)
class TipMass(Law):
    """An unknown point mass at the tip (D. J. Inman, Engineering Vibration, ch. 6).

    mass: [kg].
    """

    name: ClassVar[str] = "tip_mass"
    strength: ClassVar[str] = "mass"
    limit: ClassVar[float] = 0.2
    mass: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TipMass:
        return cls(0.015)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, tip_mass=arm.tip_mass + self.mass)


@dataclass(frozen=True)
class AddedMass(Law):
    """Mass without stiffness, evenly spread along the arm, such as tubes.

    mass: [kg].
    """

    name: ClassVar[str] = "added_mass"
    strength: ClassVar[str] = "mass"
    limit: ClassVar[float] = 0.3
    mass: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> AddedMass:
        return cls(0.04)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, added_mass=arm.added_mass + self.mass)


@dataclass(frozen=True)
class MarkerOffset(Law):
    """Offset of the markers from the neutral line.

    Markers are mounted off the neutral line on plates that rotate with the arm (U. Della Croce et al., Human
    Movement Analysis Using Stereophotogrammetry, part 4, Gait & Posture 21, 2005).

    distance: towards +x of the straight arm [m].
    """

    name: ClassVar[str] = "marker_offset"
    strength: ClassVar[str] = "distance"
    limit: ClassVar[float] = 0.04
    distance: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> MarkerOffset:
        return cls(0.004 * sign(rng))

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return np.zeros_like(angle), np.full_like(angle, self.distance)
