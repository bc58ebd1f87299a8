"""A smooth profile of the stiffness along the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
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

    first: float = amplitude(0.2, "1", lower=-3.0, upper=3.0, description="difference between base and tip")
    second: float = amplitude(0.2, "1", lower=-3.0, upper=3.0, description="difference between ends and middle")
    third: float = amplitude(0.2, "1", lower=-3.0, upper=3.0, description="term of third order")

    def stiffness(self, s: Array) -> Array:
        x = 2 * s - 1
        return np.asarray(np.exp(self.first * x + self.second * (1.5 * x * x - 0.5) + self.third * (2.5 * x**3 - 1.5 * x)))
