"""Damping that grows with rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array

#: Rate of bending of the whole arm [rad/s] up to which the implicit part bounds the tangent; up to twice this, half of it.
FASTEST = 10.0


@dataclass(frozen=True)
class QuadraticDamping(Effect):
    """m = coefficient |rate| rate."""

    name = "quadratic_damping"
    lacks = "damping grows with rate"
    cause = "air, fluid in the muscles"
    citation = "J. R. Morison et al., The force exerted by surface waves on piles, J. Pet. Technol. 2 (1950)"
    passive = True

    coefficient: float = parameter(
        0.0,
        lower=0.0,
        upper=0.2,
        unit="Nm s^2/rad^2",
        scale=0.01,
        amplitude=True,
        description="of the whole arm, per rate squared",
    )

    def moment(self, bending: Bending) -> Array:
        return np.asarray(self.coefficient * np.abs(bending.rate) * bending.rate)

    def tangent(self, keq: Array) -> tuple[Any, Any]:
        return 0.0, 2 * self.coefficient * FASTEST
