"""Stiffness that increases abruptly beyond an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array

#: Indices of the option ``side``.
BOTH, POSITIVE = 0, 1


@dataclass(frozen=True)
class BendingStop(Effect):
    """Stop that stiffens the arm beyond an angle, on both sides or on one: m = Keq ratio sign(angle) max(|angle| - stop, 0)."""

    name = "bending_stop"
    lacks = "the stiffness increases abruptly beyond an angle"
    cause = "the cable carrier's links lock"
    citation = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983)"
    kind = "elastic"
    passive = True

    ratio: float = amplitude(
        0.3, "1", lower=0.0, upper=30.0, level_exponent=-1, description="additional stiffness beyond the stop, relative to Keq"
    )
    angle: float = shape(0.5, 0.1, "rad", lower=0.2, upper=3.2, description="bending of the whole arm at which the stop begins")
    side: str = option("both", "positive", "negative", description="side on which the links lock")

    @property
    def in_space(self) -> bool:
        return self.side == "both"

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        if p.side == BOTH:
            beyond = bending.angle - limited(bending.angle, p.angle)
        elif p.side == POSITIVE:
            beyond = np.maximum(bending.angle - p.angle, 0.0)
        else:
            beyond = np.minimum(bending.angle + p.angle, 0.0)
        return bending.keq * p.ratio * beyond

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return IMPLICIT * keq * self.ratio, 0.0
