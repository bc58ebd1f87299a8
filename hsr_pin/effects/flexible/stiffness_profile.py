"""A smooth profile of the stiffness along the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class StiffnessProfile(Effect):
    """Smooth variation of the stiffness along the arm: k(s) / Keq = exp(first P1(x) + second P2(x) + third P3(x)).

    P1 to P3 are the Legendre polynomials of x = 2 s - 1.
    """

    name = "stiffness_profile"
    lacks = "bending stiffness varies along the arm"
    cause = "any variation of the body and its cladding"
    citation = "I. Elishakoff, Eigenvalues of Inhomogeneous Structures, CRC Press (2005)"
    kind = "elastic"
    flexible = True

    first: float = parameter(
        0.0, lower=-3.0, upper=3.0, unit="1", scale=0.2, amplitude=True, description="difference between base and tip"
    )
    second: float = parameter(
        0.0, lower=-3.0, upper=3.0, unit="1", scale=0.2, amplitude=True, description="difference between ends and middle"
    )
    third: float = parameter(0.0, lower=-3.0, upper=3.0, unit="1", scale=0.2, amplitude=True, description="term of third order")

    def stiffness(self, s: Array) -> Array:
        x = 2 * s - 1
        return np.asarray(np.exp(self.first * x + self.second * (1.5 * x * x - 0.5) + self.third * (2.5 * x**3 - 1.5 * x)))
