"""The moment as a curve over bending."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array

#: Bending of the whole arm [rad] beyond which the additional stiffness is constant.
FARTHEST = 2.0


@dataclass(frozen=True)
class ElasticCurve(Effect):
    """Moment that is a polynomial of bending: m = k angle (first x + second x^2 + fourth x^4), x = |angle|, at most 2 rad."""

    name = "elastic_curve"
    lacks = "the moment is a different function of bending"
    cause = "any local elasticity without memory"
    citation = "I. Kovacic, M. J. Brennan (eds.), The Duffing Equation, Wiley (2011)"
    kind = "elastic"
    flexible = True

    first: float = amplitude(0.1, "1/rad", lower=-1.0, upper=5.0, description="stiffness proportional to |bending|")
    second: float = amplitude(
        0.1, "1/rad^2", lower=-2.0, upper=5.0, description="stiffness proportional to the square of bending"
    )
    fourth: float = amplitude(
        0.1, "1/rad^4", lower=-1.0, upper=5.0, description="stiffness proportional to the fourth power of bending"
    )

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        x = np.abs(limited(bending.angle, FARTHEST))
        return bending.keq * bending.stiffness * bending.angle * (p.first * x + p.second * x**2 + p.fourth * x**4)

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        more = np.maximum(self.first, 0.0) + 1.5 * np.maximum(self.second, 0.0) + 2.5 * np.maximum(self.fourth, 0.0)
        return keq * more / 2, 0.0
