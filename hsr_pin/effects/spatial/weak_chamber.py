"""One of three chambers that pulls less than the others."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter

#: From one chamber to the next.
_NEXT = complex(-0.5, sqrt(0.75))


@dataclass(frozen=True)
class WeakChamber(Effect):
    """y = u - loss p e, p = 2/3 max(0, u.e - min over the chambers of u.e'): e the weak one's direction, three at 120 degrees.

    What each chamber gives is not recorded; they are taken to make the torque with the least pressures, one of them empty.
    """

    name = "weak_chamber"
    lacks = "the torque towards one side arrives in part"
    cause = "a chamber that leaks or whose wall is thicker, a tube that is squeezed"
    citation = "M. Cianchetti et al., Soft robotics technologies to address shortcomings in today's MIS, Soft Robot. 1 (2014)"
    kind = "actuation_map"

    loss: float = parameter(
        0.0, lower=-1.0, upper=1.0, unit="1", scale=0.1, amplitude=True, description="share of its torque that is missing"
    )
    direction: float = parameter(
        0.0, lower=-3.1416, upper=3.1416, unit="rad", scale=0.3, description="that it bends to, from x towards y of the base"
    )

    @property
    def in_plane(self) -> bool:
        return False

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        weak = np.cos(p.direction) + 1j * np.sin(p.direction)
        own, next_, last = torque * np.conj(weak), torque * np.conj(weak * _NEXT), torque * np.conj(weak / _NEXT)
        given = 2 / 3 * np.maximum(own.real - np.minimum(next_.real, last.real), 0.0)
        return torque - p.loss * given * weak, memory
