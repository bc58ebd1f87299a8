"""A smooth profile of the damping along the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class DampingProfile(Effect):
    """Smooth variation of the damping along the arm: c(s) / C = exp(first P1(x) + second P2(x)).

    P1 to P3 are the Legendre polynomials of x = 2 s - 1.
    """

    name = "damping_profile"
    lacks = "damping varies along the arm"
    cause = "tubes, cuffs, muscle ends"
    citation = "H. T. Banks, D. J. Inman, On damping mechanisms in beams, J. Appl. Mech. 58 (1991)"
    kind = "damping"
    flexible = True

    first: float = amplitude(0.3, "1", lower=-4.0, upper=4.0, description="difference between base and tip")
    second: float = amplitude(0.3, "1", lower=-4.0, upper=4.0, description="difference between ends and middle")

    def damping(self, s: Array) -> Array:
        x = 2 * s - 1
        return np.asarray(np.exp(self.first * x + self.second * (1.5 * x * x - 0.5)))
