"""Damping as a power of the rate, in both directions or in one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array

#: Rates of bending of the whole arm [rad/s]: that at which the moment equals the coefficient, and those below and above which the
#: law is linear.
UNIT, SLOWEST, FASTEST = 3.0, 0.3, 15.0
#: Indices of the option ``way``.
BOTH, POSITIVE = 0, 1


@dataclass(frozen=True)
class DampingCurve(Effect):
    """Damping that is a power of the rate: m = coefficient (|rate| / 3 rad/s)^power in the direction of the rate.

    A power of 0.3 is nearly dry friction, 2 is quadratic damping. Damping in one direction only describes a fluid that enters
    through a wide valve and leaves through a narrow one.
    """

    name = "damping_curve"
    lacks = "damping is a different function of the rate"
    cause = "any local damping"
    citation = (
        "S. J. Elliott, M. Ghandchi Tehrani, R. S. Langley, Nonlinear damping and quasi-linear modelling, "
        "Phil. Trans. A 373 (2015)"
    )
    kind = "damping"
    flexible = True
    passive = True

    coefficient: float = amplitude(0.05, "Nm", lower=0.0, upper=3.0, description="moment at 3 rad/s")
    power: float = shape(1.5, 0.3, "1", lower=0.3, upper=3.0, description="exponent of the rate")
    way: str = option("both", "positive", "negative", description="direction of motion that is damped")

    @property
    def in_space(self) -> bool:
        return self.way == "both"

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        rate = limited(bending.rate, FASTEST)
        size = np.maximum(np.abs(rate), SLOWEST) / UNIT
        if p.way == BOTH:
            resisted = bending.rate
        elif p.way == POSITIVE:
            resisted = np.maximum(bending.rate, 0.0)
        else:
            resisted = np.minimum(bending.rate, 0.0)
        return p.coefficient * size ** (p.power - 1.0) * resisted / UNIT

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        steepest = np.maximum((FASTEST / UNIT) ** (self.power - 1.0), (SLOWEST / UNIT) ** (self.power - 1.0))
        return 0.0, self.coefficient / UNIT * np.minimum(steepest, 5.0)
