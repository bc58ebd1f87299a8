"""Bending stiffness that varies along the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class StiffnessGradient(Effect):
    """Linear variation of the stiffness along the arm: k(s) / Keq = c (1 + slope (s - 1/2)), c = 2 artanh(slope / 2) / slope.

    The factor c is the mean of 1 / (1 + slope (s - 1/2)) over the arm, so that the stiffness of all springs in series stays Keq.
    """

    name = "stiffness_gradient"
    lacks = "bending stiffness varies linearly from base to tip, series stiffness kept"
    cause = "muscles taper, tubes"
    citation = "I. Elishakoff, Eigenvalues of Inhomogeneous Structures, CRC Press (2005)"
    kind = "elastic"
    passive = True

    slope: float = amplitude(
        0.3, "1", lower=-1.8, upper=1.8, description="stiffness at the tip minus stiffness at the base, relative to the middle"
    )

    def stiffness(self, s: Array) -> Array:
        x = np.asarray(self.slope) / 2
        small = np.abs(x) < 1e-3
        series_kept = np.where(small, 1 + x * x / 3, np.arctanh(x) / np.where(small, 1.0, x))
        return np.asarray(series_kept * (1 + self.slope * (s - 0.5)))
