"""A smooth loop with memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Hysteresis(Effect):
    """m = amplitude Keq z, dz = (1 - z sign(dangle)) dangle / yield_angle.

    Bouc-Wen with n = 1, beta = 1 and gamma = 0, which is Dahl's law. Along a path without reversal z is exponential in the angle:
    the update is exact, and does not depend on the rate.
    """

    name = "hysteresis"
    lacks = "smooth rate-independent loop with memory"
    cause = "braided sleeves"
    citation = (
        "Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102 (1976); P. R. Dahl (1968)"
    )
    states = 1
    passive = True

    amplitude: float = parameter(
        0.0, lower=0.0, upper=2.0, unit="rad", scale=0.05, amplitude=True, description="moment of the saturated loop over Keq"
    )
    yield_angle: float = parameter(
        0.3, lower=0.05, upper=1.5, unit="rad", scale=0.1, description="bending of the whole arm over which the loop turns"
    )

    def moment(self, bending: Bending) -> Array:
        return np.asarray(self.amplitude * bending.keq * bending.state[0])

    def tangent(self, keq: Array) -> tuple[Any, Any]:
        return self.amplitude * keq / self.yield_angle, 0.0

    def update(self, state: Array, start: Array, end: Array, elapsed: float) -> Array:
        way = end - start
        return state - (np.sign(way) - state) * np.expm1(-np.abs(way) / self.yield_angle)
