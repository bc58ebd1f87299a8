"""Changes of the plain parameters of an arm from one recording to the next."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arm import Arm, Array
from ..program import Trial
from .law import Law, strength


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
