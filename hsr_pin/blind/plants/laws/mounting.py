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
    """The base is not mounted as declared.

    The base is turned in the plane (robot-to-world calibration: B. Siciliano, O. Khatib, eds., Springer
    Handbook of Robotics, 2nd ed., ch. 6).

    form ``mount``: the base is turned in the world, and the markers show it; ``frame``: the markers'
    frame is turned with it, so that only gravity shows it.

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
    """A point mass at the tip that nobody weighed (D. J. Inman, Engineering Vibration, ch. 6).

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
    """Tubes along the arm: mass without stiffness, evenly spread.

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
    """Markers off the neutral line.

    Markers stand off the neutral line by plates that turn with the arm (U. Della Croce et al., Human
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
