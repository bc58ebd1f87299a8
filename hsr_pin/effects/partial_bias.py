"""A constant torque on the part of the arm beyond some place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter

#: Over how much of the arm it sets in, as a standard width over L: an arm of few links has to feel where that is.
_EDGE = 0.05


@dataclass(frozen=True)
class PartialBias(Effect):
    """m(s) = -bias / (1 + exp((start - s) / 0.05)): beyond ``start`` the bias is added, also before the first step."""

    name = "partial_bias"
    lacks = "a constant torque is added to the part of the arm beyond some place"
    cause = "a muscle that is shorter, glued or under pressure on a part of its way"
    citation = "R. J. Webster, B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, IJRR 29 (2010)"
    kind = "actuation_map"
    contains = ("torque_bias",)

    bias: float = parameter(
        0.0, lower=-2.0, upper=2.0, unit="Nm", scale=0.05, amplitude=True, resizes=1, description="torque added there"
    )
    start: float = parameter(0.5, lower=0.0, upper=1.0, unit="1", scale=0.1, description="arc length over L, from where on")

    @property
    def in_space(self) -> bool:
        return False

    @property
    def placeless(self) -> bool:
        return False

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -p.bias / (1 + np.exp((p.start - bending.place) / _EDGE)) + 0.0 * bending.angle
