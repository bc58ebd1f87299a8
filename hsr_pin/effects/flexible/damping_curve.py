"""Damping over rate, as a power, both ways or one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array

#: Rate of bending of the whole arm [rad/s] at which the moment is the coefficient; below SLOWEST and beyond FASTEST it is a line.
UNIT, SLOWEST, FASTEST = 3.0, 0.3, 15.0
#: Ways in the order of the option.
BOTH, POSITIVE = 0, 1


@dataclass(frozen=True)
class DampingCurve(Effect):
    """m = coefficient (|rate| / 3 rad/s)^power in the direction of the rate: 0.3 is nearly dry, 2 is quadratic.

    Both ways, or one way only: what has flowed in through a wide valve leaves through a narrow one.
    """

    name = "damping_curve"
    lacks = "damping is another function of the rate"
    cause = "any damping that is local"
    citation = (
        "S. J. Elliott, M. Ghandchi Tehrani, R. S. Langley, Nonlinear damping and quasi-linear modelling, "
        "Phil. Trans. A 373 (2015)"
    )
    kind = "damping"
    flexible = True
    passive = True

    coefficient: float = parameter(
        0.0, lower=0.0, upper=3.0, unit="Nm", scale=0.05, amplitude=True, description="moment at 3 rad/s"
    )
    power: float = parameter(1.5, lower=0.3, upper=3.0, unit="1", scale=0.3, description="of the rate")
    way: str = option("both", "positive", "negative", description="in which the arm moves when it is resisted")

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
