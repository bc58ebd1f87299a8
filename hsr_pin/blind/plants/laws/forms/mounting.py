"""Mounts, masses and markers in forms that differ from the catalogue's."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arm import Arm, Array
from ...program import Trial
from ..law import Law, drawn, sign, strength, uniform
from .scale import KEQ


@dataclass(frozen=True)
class SaggingMount(Law, name="gravity_tilt", variant="sagging"):
    """A mount that creeps over the session, so that the tilt grows with every trial.

    Creep of a clamped joint (W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic
    Materials, 1976, ch. 5).

    angle: final tilt towards positive bending [rad]; time: time constant, in session time [s].
    """

    angle: float = strength(0.05, limit=0.6, signed=True)
    time: float = uniform(30.0, 90.0, default=60.0)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, tilt=arm.tilt + self.angle * (1 - 0.7 * np.exp(-trial.clock / self.time)))


@dataclass(frozen=True)
class Remounted(Law, name="gravity_tilt", variant="remounted"):
    """An arm that was removed and clamped again between its stiffness levels, with another tilt.

    Repeatability of a mount (A. H. Slocum, Precision Machine Design, 1992, ch. 7).

    angle: tilt at the lower level, towards positive bending [rad]; second: tilt at the others relative to it [-].
    """

    angle: float = strength(0.05, limit=0.6, signed=True)
    second: float = uniform(0.0, 0.6, default=0.3)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        share = 1.0 if trial.keq <= KEQ else self.second
        return replace(arm, tilt=arm.tilt + self.angle * share)


@dataclass(frozen=True)
class Ring(Law, name="tip_mass", variant="ring"):
    """A heavy ring near the tip (D. J. Inman, Engineering Vibration, ch. 6).

    mass: [kg]; place: over L.
    """

    mass: float = strength(0.02, limit=0.25)
    place: float = uniform(0.78, 0.92, default=0.85)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, lumps=(*arm.lumps, (self.place * arm.length, self.mass)))


@dataclass(frozen=True)
class Overhang(Law, name="tip_mass", variant="overhang"):
    """A tool with its mass beyond the tip (B. Siciliano, O. Khatib, eds., Springer Handbook of Robotics, 2nd ed., ch. 3).

    mass: [kg]; beyond: distance from the tip along the arm, over L.
    """

    mass: float = strength(0.015, limit=0.2)
    beyond: float = uniform(0.1, 0.25, default=0.15)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, lumps=(*arm.lumps, ((1 + self.beyond) * arm.length, self.mass)))


@dataclass(frozen=True)
class HalfHose(Law, name="added_mass", variant="half_hose"):
    """A hose along a part of the arm, with its mass spread from `start` to `end`.

    D. J. Inman, Engineering Vibration, ch. 6: distributed mass as eight lumps.

    mass: [kg]; start, end: over L.
    """

    mass: float = strength(0.06, limit=0.4)
    start: float = 0.0
    end: float = uniform(0.6, 0.8, default=0.6)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        places = self.start + (self.end - self.start) * (np.arange(8) + 0.5) / 8
        return replace(arm, lumps=(*arm.lumps, *((float(s) * arm.length, self.mass / 8) for s in places)))


@dataclass(frozen=True)
class GrowingMass(Law, name="added_mass", variant="growing"):
    """Mass per length that grows towards the tip, such as tubes and fittings near the tip.

    D. J. Inman, Engineering Vibration, ch. 6: a linearly growing density as eight lumps.

    mass: [kg].
    """

    mass: float = strength(0.03, limit=0.3)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        s = (np.arange(8) + 0.5) / 8
        return replace(arm, lumps=(*arm.lumps, *((float(x) * arm.length, self.mass * float(x) / 4) for x in s)))


@dataclass(frozen=True)
class UnevenPlates(Law, name="marker_offset", variant="uneven"):
    """Marker plates of different heights (U. Della Croce et al., Gait & Posture 21, 2005).

    distance: of the middle marker, towards +x of the straight arm [m]; growth: relative change from base to tip [-].
    """

    distance: float = strength(0.004, limit=0.04, signed=True)
    growth: float = drawn(lambda rng: float(rng.uniform(0.6, 1.6)) * sign(rng), default=1.0)

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return np.zeros_like(angle), np.full_like(angle, self.distance * (1 + self.growth * (s - 0.5)))


@dataclass(frozen=True)
class SlidingSleeve(Law, name="marker_offset", variant="sleeve"):
    """Markers on a sleeve that lifts off and slides as the arm bends.

    Soft tissue artefact (A. Leardini et al., Human Movement Analysis Using Stereophotogrammetry, part 3, Gait & Posture 21,
    2005): off the line by a distance that grows with the bending, and back along the arm.

    distance: [m]; lift: its growth with the direction of the arm [1/rad]; slide: along the arm, over distance and angle [-].
    """

    distance: float = strength(0.004, limit=0.04, signed=True)
    lift: float = uniform(0.4, 1.2, default=0.8)
    slide: float = uniform(0.3, 0.8, default=0.5)

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return -abs(self.distance) * self.slide * np.abs(angle), self.distance * (1 + self.lift * angle)
