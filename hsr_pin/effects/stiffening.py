"""Stiffness that increases or decreases with bending."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.effects.vector import chosen, limited
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array

#: Range of the additional tangent stiffness, relative to that of the arm; beyond it the law is continued as a straight line.
SOFTEST, STIFFEST = 0.8, 20.0
#: Bending [rad] up to which the integrator's implicit part covers half of the tangent; a stiff arm bends less, so less is
#: covered.
REACH = 2.0


@dataclass(frozen=True)
class Stiffening(Effect):
    """Cubic stiffness: m = k cubic angle^3, continued along its tangent where that reaches -0.8 k or 20 k.

    The total stiffness therefore stays positive.
    """

    name = "stiffening"
    lacks = "stiffness increases (or decreases) with bending"
    cause = "braid geometry, silicone"
    citation = "I. Kovacic, M. J. Brennan (eds.), The Duffing Equation, Wiley (2011)"
    kind = "elastic"
    passive = True

    cubic: float = amplitude(
        0.1, "1/rad^2", lower=-1.0, upper=5.0, description="relative change of the secant stiffness at 1 rad"
    )

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        limit = chosen(p.cubic < 0, SOFTEST, STIFFEST)
        last = np.sqrt(limit / (3 * np.maximum(np.abs(p.cubic), 1e-9)))  # [rad] where the tangent reaches its limit
        angle = limited(bending.angle, last)
        relative = p.cubic * np.abs(angle) ** 2 * (angle + 3 * (bending.angle - angle))
        return bending.keq * bending.stiffness * relative

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        cubic = np.maximum(self.cubic, 0.0)
        reach = 1 / (1 / REACH + np.cbrt(cubic / REACH))  # [rad] about where cubic * angle^3 is REACH
        return keq * 1.5 * cubic * reach**2, 0.0
