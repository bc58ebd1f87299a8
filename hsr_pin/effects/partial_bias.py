"""A constant torque on the outer part of the arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import amplitude, shape

#: Width of the transition, relative to L: wide enough that an arm of few links depends on its position.
_EDGE = 0.05


@dataclass(frozen=True)
class PartialBias(Effect):
    """Constant torque beyond the arc length ``start``, also before the first step: m = -bias / (1 + exp((start - s) / 0.05))."""

    name = "partial_bias"
    lacks = "a constant torque is added to the outer part of the arm"
    cause = "a muscle that is shorter, glued or pressurised along a part of its length"
    citation = "R. J. Webster, B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, IJRR 29 (2010)"
    kind = "actuation_map"
    in_space = False
    contains = ("torque_bias",)

    bias: float = amplitude(0.05, "Nm", lower=-2.0, upper=2.0, level_exponent=1, description="additional torque")
    start: float = shape(0.5, 0.1, "1", lower=0.0, upper=1.0, description="relative arc length at which it begins")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -p.bias / (1 + np.exp((p.start - bending.place) / _EDGE)) + 0.0 * bending.angle
