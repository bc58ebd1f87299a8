"""Mounts, masses and markers in forms that differ from the catalogue's."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...arm import Arm, Array
from ...program import Trial
from ..law import Law, sign
from .scale import KEQ


@dataclass(frozen=True)
class SaggingMount(Law):
    """A mount that creeps over the session, so that the tilt grows with every trial.

    Creep of a clamped joint (W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic
    Materials, 1976, ch. 5).

    angle: final tilt towards positive bending [rad]; time: time constant, in session time [s].
    """

    name: ClassVar[str] = "gravity_tilt"
    variant: ClassVar[str] = "sagging"
    strength: ClassVar[str] = "angle"
    limit: ClassVar[float] = 0.6
    angle: float = 0.0
    time: float = 60.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> SaggingMount:
        return cls(0.05 * sign(rng), float(rng.uniform(30.0, 90.0)))

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, tilt=arm.tilt + self.angle * (1 - 0.7 * np.exp(-trial.clock / self.time)))


@dataclass(frozen=True)
class Remounted(Law):
    """An arm that was removed and clamped again between its stiffness levels, with another tilt.

    Repeatability of a mount (A. H. Slocum, Precision Machine Design, 1992, ch. 7).

    angle: tilt at the lower level, towards positive bending [rad]; second: tilt at the others relative to it [-].
    """

    name: ClassVar[str] = "gravity_tilt"
    variant: ClassVar[str] = "remounted"
    strength: ClassVar[str] = "angle"
    limit: ClassVar[float] = 0.6
    angle: float = 0.0
    second: float = 0.3

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Remounted:
        return cls(0.05 * sign(rng), float(rng.uniform(0.0, 0.6)))

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        share = 1.0 if trial.keq <= KEQ else self.second
        return replace(arm, tilt=arm.tilt + self.angle * share)


@dataclass(frozen=True)
class Ring(Law):
    """A heavy ring near the tip (D. J. Inman, Engineering Vibration, ch. 6).

    mass: [kg]; place: over L.
    """

    name: ClassVar[str] = "tip_mass"
    variant: ClassVar[str] = "ring"
    strength: ClassVar[str] = "mass"
    limit: ClassVar[float] = 0.25
    mass: float = 0.0
    place: float = 0.85

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Ring:
        return cls(0.02, float(rng.uniform(0.78, 0.92)))

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, lumps=(*arm.lumps, (self.place * arm.length, self.mass)))


@dataclass(frozen=True)
class Overhang(Law):
    """A tool with its mass beyond the tip (B. Siciliano, O. Khatib, eds., Springer Handbook of Robotics, 2nd ed., ch. 3).

    mass: [kg]; beyond: distance from the tip along the arm, over L.
    """

    name: ClassVar[str] = "tip_mass"
    variant: ClassVar[str] = "overhang"
    strength: ClassVar[str] = "mass"
    limit: ClassVar[float] = 0.2
    mass: float = 0.0
    beyond: float = 0.15

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Overhang:
        return cls(0.015, float(rng.uniform(0.1, 0.25)))

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, lumps=(*arm.lumps, ((1 + self.beyond) * arm.length, self.mass)))


@dataclass(frozen=True)
class HalfHose(Law):
    """A hose along a part of the arm, with its mass spread from `start` to `end`.

    D. J. Inman, Engineering Vibration, ch. 6: distributed mass as eight lumps.

    mass: [kg]; start, end: over L.
    """

    name: ClassVar[str] = "added_mass"
    variant: ClassVar[str] = "half_hose"
    strength: ClassVar[str] = "mass"
    limit: ClassVar[float] = 0.4
    mass: float = 0.0
    start: float = 0.0
    end: float = 0.6

    @classmethod
    def draw(cls, rng: np.random.Generator) -> HalfHose:
        return cls(0.06, 0.0, float(rng.uniform(0.6, 0.8)))

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        places = self.start + (self.end - self.start) * (np.arange(8) + 0.5) / 8
        return replace(arm, lumps=(*arm.lumps, *((float(s) * arm.length, self.mass / 8) for s in places)))


@dataclass(frozen=True)
class GrowingMass(Law):
    """Mass per length that grows towards the tip, such as tubes and fittings near the tip.

    D. J. Inman, Engineering Vibration, ch. 6: a linearly growing density as eight lumps.

    mass: [kg].
    """

    name: ClassVar[str] = "added_mass"
    variant: ClassVar[str] = "growing"
    strength: ClassVar[str] = "mass"
    limit: ClassVar[float] = 0.3
    mass: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> GrowingMass:
        return cls(0.03)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        s = (np.arange(8) + 0.5) / 8
        return replace(arm, lumps=(*arm.lumps, *((float(x) * arm.length, self.mass * float(x) / 4) for x in s)))


@dataclass(frozen=True)
class UnevenPlates(Law):
    """Marker plates of different heights (U. Della Croce et al., Gait & Posture 21, 2005).

    distance: of the middle marker, towards +x of the straight arm [m]; growth: relative change from base to tip [-].
    """

    name: ClassVar[str] = "marker_offset"
    variant: ClassVar[str] = "uneven"
    strength: ClassVar[str] = "distance"
    limit: ClassVar[float] = 0.04
    distance: float = 0.0
    growth: float = 1.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> UnevenPlates:
        return cls(0.004 * sign(rng), float(rng.uniform(0.6, 1.6)) * sign(rng))

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return np.zeros_like(angle), np.full_like(angle, self.distance * (1 + self.growth * (s - 0.5)))


@dataclass(frozen=True)
class SlidingSleeve(Law):
    """Markers on a sleeve that lifts off and slides as the arm bends.

    Soft tissue artefact (A. Leardini et al., Human Movement Analysis Using Stereophotogrammetry, part 3, Gait & Posture 21,
    2005): off the line by a distance that grows with the bending, and back along the arm.

    distance: [m]; lift: its growth with the direction of the arm [1/rad]; slide: along the arm, over distance and angle [-].
    """

    name: ClassVar[str] = "marker_offset"
    variant: ClassVar[str] = "sleeve"
    strength: ClassVar[str] = "distance"
    limit: ClassVar[float] = 0.04
    distance: float = 0.0
    lift: float = 0.8
    slide: float = 0.5

    @classmethod
    def draw(cls, rng: np.random.Generator) -> SlidingSleeve:
        return cls(0.004 * sign(rng), float(rng.uniform(0.4, 1.2)), float(rng.uniform(0.3, 0.8)))

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return -abs(self.distance) * self.slide * np.abs(angle), self.distance * (1 + self.lift * angle)
