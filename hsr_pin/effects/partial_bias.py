"""A constant torque on the outer part of the arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter

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
    contains = ("torque_bias",)

    bias: float = parameter(
        0.0, lower=-2.0, upper=2.0, unit="Nm", scale=0.05, amplitude=True, level_exponent=1, description="additional torque"
    )
    start: float = parameter(0.5, lower=0.0, upper=1.0, unit="1", scale=0.1, description="relative arc length at which it begins")

    @property
    def in_space(self) -> bool:
        return False

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -p.bias / (1 + np.exp((p.start - bending.place) / _EDGE)) + 0.0 * bending.angle
