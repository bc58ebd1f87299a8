"""Stiffness that jumps beyond an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class BendingStop(Effect):
    """m = Keq ratio sign(angle) max(|angle| - stop, 0)."""

    name = "bending_stop"
    lacks = "stiffness jumps beyond an angle"
    cause = "the cable carrier's links lock"
    citation = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983)"
    kind = "elastic"
    passive = True

    ratio: float = parameter(
        0.0,
        lower=0.0,
        upper=30.0,
        unit="1",
        scale=0.3,
        amplitude=True,
        resizes=-1,
        description="stiffness added beyond the stop, over Keq",
    )
    angle: float = parameter(0.5, lower=0.2, upper=3.2, unit="rad", scale=0.1, description="bending of the whole arm at the stop")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return bending.keq * p.ratio * (bending.angle - limited(bending.angle, p.angle))

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return IMPLICIT * keq * self.ratio, 0.0
