"""A part of the arm that is softer or stiffer than the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class SoftSpot(Effect):
    """Local change of the stiffness: k(s) / Keq = 1 - depth exp(-((s - centre) / width)^2 / 2)."""

    name = "soft_spot"
    lacks = "one part of the arm is softer or stiffer"
    cause = "a worn or cracked backbone link"
    citation = (
        "S. Christides, A. D. S. Barr, One-dimensional theory of cracked Bernoulli-Euler beams, Int. J. Mech. Sci. 26 (1984)"
    )
    kind = "elastic"
    passive = True

    depth: float = amplitude(
        0.3, "1", lower=-3.0, upper=0.95, description="relative loss of stiffness at the centre (negative: gain)"
    )
    centre: float = shape(0.5, 0.1, "1", lower=0.0, upper=1.0, description="relative arc length of the centre")
    width: float = shape(0.1, 0.05, "1", lower=0.02, upper=0.4, description="standard deviation of the profile, relative to L")

    def stiffness(self, s: Array) -> Array:
        return np.asarray(1 - self.depth * np.exp(-(((s - self.centre) / self.width) ** 2) / 2))
