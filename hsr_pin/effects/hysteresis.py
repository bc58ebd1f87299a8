"""A smooth loop with memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect, option
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array

#: Where the sliders slip, over the yield angle.
SLIDERS = np.array([0.2, 0.6, 1.0, 1.4, 1.8])


@dataclass(frozen=True)
class Hysteresis(Effect):
    """m = amplitude Keq z.

    dahl: dz = (1 - z sign(dangle)) dangle / yield_angle, which is Bouc-Wen with n = 1, beta = 1, gamma = 0: along a path without
    reversal z is exponential in the angle. maxwell_slip: z is the mean of five sliders that follow dangle / yield_angle and slip
    at 0.2, 0.6 ... 1.8, so that the loop closes where it began (Iwan's law with evenly spread sliders). Both updates are exact
    for an angle that does not turn back within a step, and do not depend on the rate.
    """

    name = "hysteresis"
    lacks = "smooth rate-independent loop with memory"
    cause = "braided sleeves"
    citation = (
        "Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102 (1976); P. R. Dahl (1968); "
        "W. D. Iwan, A distributed-element model for hysteresis, J. Appl. Mech. 33 (1966)"
    )
    states = len(SLIDERS)
    passive = True

    amplitude: float = parameter(
        0.0, lower=0.0, upper=2.0, unit="rad", scale=0.05, amplitude=True, description="moment of the saturated loop over Keq"
    )
    yield_angle: float = parameter(
        0.3, lower=0.05, upper=1.5, unit="rad", scale=0.1, description="bending of the whole arm over which the loop turns"
    )

    form: str = option("dahl", "maxwell_slip", description="exponential approach to the loop, or sliders that slip one by one")

    def moment(self, bending: Bending) -> Array:
        loop = bending.state[0] if self.form == "dahl" else bending.state.mean(axis=0)
        return np.asarray(self.amplitude * bending.keq * loop)

    def tangent(self, keq: Array) -> tuple[Any, Any]:
        return self.amplitude * keq / self.yield_angle, 0.0

    def update(self, state: Array, start: Array, end: Array, elapsed: float) -> Array:
        way = (end - start) / self.yield_angle
        if self.form == "dahl":
            return state - (np.sign(way) - state) * np.expm1(-np.abs(way))
        slip = SLIDERS.reshape(-1, *[1] * np.ndim(way))
        return np.clip(state + way, -slip, slip)
