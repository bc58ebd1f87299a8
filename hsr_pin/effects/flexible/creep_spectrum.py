"""Relaxation with several time constants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array

#: Time constants of the branches [s].
TIMES = np.array([0.1, 0.6, 4.0])


@dataclass(frozen=True)
class CreepSpectrum(Effect):
    """Generalised Maxwell solid with three time constants: m = Keq sum of ratio_k e_k, de_k/dt = dangle/dt - e_k / T_k.

    The time constants are 0.1, 0.6 and 4 s.
    """

    name = "creep_spectrum"
    lacks = "creep and relaxation with several time constants"
    cause = "any linear viscoelasticity"
    citation = "J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed., Wiley (1980)"
    kind = "creep"
    flexible = True
    states = len(TIMES)
    passive = True

    fast: float = amplitude(0.1, "1", lower=0.0, upper=3.0, description="stiffness of the branch of 0.1 s relative to Keq")
    middle: float = amplitude(0.1, "1", lower=0.0, upper=3.0, description="stiffness of the branch of 0.6 s relative to Keq")
    slow: float = amplitude(0.1, "1", lower=0.0, upper=3.0, description="stiffness of the branch of 4 s relative to Keq")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        e = bending.memory
        return bending.keq * (p.fast * e[0] + p.middle * e[1] + p.slow * e[2])

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        x = elapsed / TIMES[k]
        return memory * np.exp(-x) - (end - start) * np.expm1(-x) / x

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return keq * (self.fast + self.middle + self.slow) / 2, 0.0
