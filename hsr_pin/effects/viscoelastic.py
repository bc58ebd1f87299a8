"""Creep and relaxation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Viscoelastic(Effect):
    """Maxwell branch parallel to the spring (standard linear solid): m = ratio Keq e, de/dt = dangle/dt - e / time_constant.

    e is the elongation of the branch's spring; the update is exact for an angle that changes uniformly.
    """

    name = "viscoelastic"
    lacks = "creep and relaxation"
    cause = "silicone"
    citation = "J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley (1980)"
    kind = "creep"
    states = 1
    passive = True

    ratio: float = amplitude(
        0.2, "1", lower=0.0, upper=3.0, level_exponent=-1, description="stiffness of the branch relative to Keq"
    )
    time_constant: float = shape(0.5, 0.2, "s", lower=0.03, upper=10.0, description="time constant of relaxation")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return p.ratio * bending.keq * bending.memory[0]

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        x = elapsed / p.time_constant
        return memory * np.exp(-x) - (end - start) * np.expm1(-x) / x

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return self.ratio * keq / 2, 0.0
