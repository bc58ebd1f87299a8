"""Changes from one recording of an arm to the next: its plain parameters, and its rest pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..arm import Arm, Array
from ..program import Trial
from .law import Law, sign


@dataclass(frozen=True)
class KeqScale(Law):
    """Stiffness of the whole arm (L. Mullins, Softening of Rubber by Deformation, Rubber Chem. Technol. 42, 1969).

    change: relative change of the bending stiffness [-].
    """

    name: ClassVar[str] = "keq_scale"
    strength: ClassVar[str] = "change"
    limit: ClassVar[float] = 0.6
    change: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> KeqScale:
        return cls(0.08 * sign(rng))

    def stiffness(self, s: Array) -> Array:
        return np.full_like(s, 1 + self.change)


@dataclass(frozen=True)
class DampingScale(Law):
    """Damping of the whole arm (C. W. de Silva, Vibration Damping, Control and Design, 2007, ch. 1).

    change: relative change of the damping [-], from -0.8 to `limit`.
    """

    name: ClassVar[str] = "damping_scale"
    strength: ClassVar[str] = "change"
    limit: ClassVar[float] = 3.0
    change: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> DampingScale:
        return cls(0.3 * sign(rng))

    def scaled(self, factor: float) -> DampingScale:
        return DampingScale(float(np.clip(self.change * factor, -0.8, self.limit)))

    def damping(self, s: Array) -> Array:
        return np.full_like(s, 1 + self.change)


@dataclass(frozen=True)
class MassScale(Law):
    """Mass of the arm, such as soaked material or new fittings along the arm.

    change: relative change of its own mass [-].
    """

    name: ClassVar[str] = "mass_scale"
    strength: ClassVar[str] = "change"
    limit: ClassVar[float] = 2.0
    change: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> MassScale:
        return cls(0.2)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, mass=arm.mass * (1 + self.change))


@dataclass(frozen=True)
class TorqueGain(Law):
    """Gain of the actuators (F. Daerden, D. Lefeber, Pneumatic Artificial Muscles, 2002).

    change: relative change of the torque [-].
    """

    name: ClassVar[str] = "torque_gain"
    strength: ClassVar[str] = "change"
    limit: ClassVar[float] = 0.6
    change: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TorqueGain:
        return cls(0.08 * sign(rng))

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return tau * (1 + self.change)


@dataclass(frozen=True)
class RestingPlace(Law):
    """Scatter of the rest pose from trial to trial, constant within a trial.

    Real arms show it if they are set up by hand or have a little friction. The law is a small moment along the arm, another one
    in each trial.

    spread: largest bending of the whole arm [rad]; seed: seed of the moments, combined with the session time.
    """

    name: ClassVar[str] = "resting_place"
    strength: ClassVar[str] = "spread"
    limit: ClassVar[float] = 0.1
    spread: float = 0.0
    seed: int = 0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> RestingPlace:
        return cls(0.01, int(rng.integers(1 << 31)))

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        own = np.random.default_rng([self.seed, round(100 * clock)]).uniform(-1, 1)
        return tau + self.spread * own * keq
