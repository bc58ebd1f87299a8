"""One of three chambers that delivers less torque than the others."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude, shape

#: Rotation from one chamber to the next.
_NEXT = complex(-0.5, sqrt(0.75))


@dataclass(frozen=True)
class WeakChamber(Effect):
    """Loss of torque of one of three chambers: y = u - loss p e, where e is the direction of the weak chamber.

    Its share of the torque is p = 2/3 max(0, u.e - min over the chambers of u.e'); the chambers are at 120 degrees. The torques
    of the chambers are not recorded; they are assumed to produce the total torque with the smallest pressures, so that one
    chamber is empty.
    """

    name = "weak_chamber"
    lacks = "the torque towards one side arrives only in part"
    cause = "a chamber that leaks or whose wall is thicker, a tube that is squeezed"
    citation = "M. Cianchetti et al., Soft robotics technologies to address shortcomings in today's MIS, Soft Robot. 1 (2014)"
    kind = "actuation_map"
    in_plane = False

    loss: float = amplitude(0.1, "1", lower=-1.0, upper=1.0, description="missing share of its torque")
    direction: float = shape(
        0.0, 0.3, "rad", lower=-3.1416, upper=3.1416, description="direction of its bending, from x towards y of the base"
    )

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        weak = np.cos(p.direction) + 1j * np.sin(p.direction)
        own, next_, last = torque * np.conj(weak), torque * np.conj(weak * _NEXT), torque * np.conj(weak / _NEXT)
        given = 2 / 3 * np.maximum(own.real - np.minimum(next_.real, last.real), 0.0)
        return torque - p.loss * given * weak, memory
