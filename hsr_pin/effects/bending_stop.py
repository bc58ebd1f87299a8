"""Stiffness that jumps beyond an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class BendingStop(Effect):
    """m = Keq ratio sign(angle) max(|angle| - stop, 0)."""

    name = "bending_stop"
    lacks = "stiffness jumps beyond an angle"
    cause = "the cable carrier's links lock"
    citation = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983)"
    passive = True

    ratio: float = parameter(
        0.0, lower=0.0, upper=30.0, unit="1", scale=0.3, amplitude=True, description="stiffness added beyond the stop, over Keq"
    )
    angle: float = parameter(0.5, lower=0.2, upper=3.2, unit="rad", scale=0.1, description="bending of the whole arm at the stop")

    def moment(self, bending: Bending) -> Array:
        beyond = bending.angle - np.clip(bending.angle, -self.angle, self.angle)
        return np.asarray(bending.keq * self.ratio * beyond)

    def tangent(self, keq: Array) -> tuple[Any, Any]:
        return keq * self.ratio / 2, 0.0
