"""Changes from one recording of an arm to the next: its plain parameters, and its rest pose."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arm import Arm, Array
from ..program import Trial
from .law import Law, random_seed, strength


@dataclass(frozen=True)
class KeqScale(Law, name="keq_scale"):
    """Stiffness of the whole arm (L. Mullins, Softening of Rubber by Deformation, Rubber Chem. Technol. 42, 1969).

    change: relative change of the bending stiffness [-].
    """

    change: float = strength(0.08, limit=0.6, signed=True)

    def stiffness(self, s: Array) -> Array:
        return np.full_like(s, 1 + self.change)


@dataclass(frozen=True)
class DampingScale(Law, name="damping_scale"):
    """Damping of the whole arm (C. W. de Silva, Vibration Damping, Control and Design, 2007, ch. 1).

    change: relative change of the damping [-], from -0.8 to `limit`.
    """

    change: float = strength(0.3, limit=3.0, signed=True)

    def scaled(self, factor: float) -> DampingScale:
        return DampingScale(float(np.clip(self.change * factor, -0.8, self.limit)))

    def damping(self, s: Array) -> Array:
        return np.full_like(s, 1 + self.change)


@dataclass(frozen=True)
class MassScale(Law, name="mass_scale"):
    """Mass of the arm, such as soaked material or new fittings along the arm.

    change: relative change of its own mass [-].
    """

    change: float = strength(0.2, limit=2.0)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, mass=arm.mass * (1 + self.change))


@dataclass(frozen=True)
class TorqueGain(Law, name="torque_gain"):
    """Gain of the actuators (F. Daerden, D. Lefeber, Pneumatic Artificial Muscles, 2002).

    change: relative change of the torque [-].
    """

    change: float = strength(0.08, limit=0.6, signed=True)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return tau * (1 + self.change)


@dataclass(frozen=True)
class RestingPlace(Law, name="resting_place"):
    """Scatter of the rest pose from trial to trial, constant within a trial.

    Real arms show it if they are set up by hand or have a little friction. The law is a small moment along the arm, another one
    in each trial.

    spread: largest bending of the whole arm [rad]; seed: seed of the moments, combined with the session time.
    """

    spread: float = strength(0.01, limit=0.1)
    seed: int = random_seed()

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        own = np.random.default_rng([self.seed, round(100 * clock)]).uniform(-1, 1)
        return tau + self.spread * own * keq
