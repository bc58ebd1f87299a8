"""A smooth hysteresis loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect, option
from hsr_pin.effects.vector import limited, unit
from hsr_pin.parameters import amplitude as amplitude_field
from hsr_pin.parameters import shape
from hsr_pin.trajectory import Array

#: Slip of each slider, relative to the yield angle.
SLIDERS = np.array([0.2, 0.6, 1.0, 1.4, 1.8])
#: Index of the form "dahl".
DAHL = 0


@dataclass(frozen=True)
class Hysteresis(Effect):
    """Smooth rate-independent hysteresis: m = amplitude Keq z.

    - dahl: dz = (1 - z sign(dangle)) dangle / yield_angle, which is Bouc-Wen with n = 1, beta = 1, gamma = 0. Along a path
      without reversal, z is exponential in the angle.
    - maxwell_slip: z is the mean of five sliders that follow dangle / yield_angle and slip at 0.2, 0.6 ... 1.8, so that the loop
      closes where it began (Iwan's law with evenly distributed sliders).

    Both updates are exact for an angle that does not reverse within a step, and do not depend on the rate.
    """

    name = "hysteresis"
    lacks = "smooth rate-independent loop with memory"
    cause = "braided sleeves"
    citation = (
        "Y.-K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102 (1976); P. R. Dahl (1968); "
        "W. D. Iwan, A distributed-element model for hysteresis, J. Appl. Mech. 33 (1966)"
    )
    kind = "friction"
    states = len(SLIDERS)
    passive = True

    amplitude: float = amplitude_field(
        0.05, "rad", lower=0.0, upper=2.0, level_exponent=-1, description="moment of the saturated loop relative to Keq"
    )
    yield_angle: float = shape(
        0.3, 0.1, "rad", lower=0.05, upper=1.5, description="bending of the whole arm over which the loop saturates"
    )

    form: str = option(
        "dahl", "maxwell_slip", description="exponential approach to the loop, or sliders that slip one after another"
    )

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        z = bending.memory
        loop = z[0] if p.form == DAHL else (z[0] + z[1] + z[2] + z[3] + z[4]) / 5
        return p.amplitude * bending.keq * loop

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        way = (end - start) / p.yield_angle
        if p.form == DAHL:
            return memory - (unit(way) - memory) * np.expm1(-np.abs(way))
        return limited(memory + way, SLIDERS[k])

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        steepest = 2 if self.form == "dahl" else 1  # where Dahl's law turns back
        return IMPLICIT * steepest * self.amplitude * keq / self.yield_angle, 0.0
