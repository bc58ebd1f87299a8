"""Damping that increases with the rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array

#: Rate of bending of the whole arm [rad/s] beyond which the law is continued along its tangent, so that its slope is bounded.
FASTEST = 15.0


@dataclass(frozen=True)
class QuadraticDamping(Effect):
    """Damping moment proportional to the squared rate: m = coefficient |rate| rate, continued along its tangent beyond 15 rad/s.

    Only the outermost link is faster, in the first instant after a step.
    """

    name = "quadratic_damping"
    lacks = "damping increases with the rate"
    cause = "air, fluid in the muscles"
    citation = "J. R. Morison et al., The force exerted by surface waves on piles, J. Pet. Technol. 2 (1950)"
    kind = "damping"
    passive = True

    coefficient: float = amplitude(
        0.005,
        "Nm s^2/rad^2",
        lower=0.0,
        upper=2.0,
        level_exponent=1,
        description="damping moment of the whole arm per squared rate",
    )

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        rate = limited(bending.rate, FASTEST)
        return p.coefficient * np.abs(rate) * (2 * bending.rate - rate)

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return 0.0, IMPLICIT * 2 * self.coefficient * FASTEST
