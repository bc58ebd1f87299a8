"""A smooth profile of the torque along the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class TorqueProfile(Effect):
    """Smooth variation of the torque along the arm: tau(s) / tau = 1 + first P1(x) + second P2(x) + third P3(x).

    P1 to P3 are the Legendre polynomials of x = 2 s - 1; the mean torque is unchanged.
    """

    name = "torque_profile"
    lacks = "the share of the torque that arrives varies along the arm"
    cause = "muscles that end, taper or rub along the backbone"
    citation = "D. B. Camarillo et al., Mechanics modeling of tendon-driven continuum manipulators, IEEE Trans. Robot. 24 (2008)"
    kind = "actuation_map"
    flexible = True

    first: float = amplitude(0.2, "1", lower=-2.0, upper=2.0, description="difference between base and tip")
    second: float = amplitude(0.2, "1", lower=-2.0, upper=2.0, description="difference between ends and middle")
    third: float = amplitude(0.2, "1", lower=-2.0, upper=2.0, description="term of third order")

    def actuation(self, s: Array) -> Array:
        x = 2 * s - 1
        return np.asarray(1 + self.first * x + self.second * (1.5 * x * x - 0.5) + self.third * (2.5 * x**3 - 1.5 * x))
