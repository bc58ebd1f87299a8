"""Any stiffness along the arm that has few waves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class StiffnessProfile(Effect):
    """k(s) / Keq = exp(first P1(x) + second P2(x) + third P3(x)), P the Legendre polynomials of x = 2 s - 1."""

    name = "stiffness_profile"
    lacks = "bending stiffness is another at every place of the arm"
    cause = "whatever the arm is made of and clad with"
    citation = "I. Elishakoff, Eigenvalues of Inhomogeneous Structures, CRC Press (2005)"
    kind = "elastic"
    flexible = True

    first: float = parameter(0.0, lower=-3.0, upper=3.0, unit="1", scale=0.2, amplitude=True, description="from base to tip")
    second: float = parameter(0.0, lower=-3.0, upper=3.0, unit="1", scale=0.2, amplitude=True, description="ends against middle")
    third: float = parameter(0.0, lower=-3.0, upper=3.0, unit="1", scale=0.2, amplitude=True, description="of third order")

    def stiffness(self, s: Array) -> Array:
        x = 2 * s - 1
        return np.asarray(np.exp(self.first * x + self.second * (1.5 * x * x - 0.5) + self.third * (2.5 * x**3 - 1.5 * x)))
