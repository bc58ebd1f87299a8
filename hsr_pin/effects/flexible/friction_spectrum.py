"""Hysteresis loops of any shape: sliders that slip one after another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array

#: Bending of the whole arm at which each slider slips [rad].
SLIPS = np.array([0.03, 0.12, 0.4, 1.2])


@dataclass(frozen=True)
class FrictionSpectrum(Effect):
    """Friction of four sliders: m = Keq sum of level_k z_k / slip_k, dz_k = dangle while |z_k| < slip_k.

    This is Iwan's law with free slider strengths.
    """

    name = "friction_spectrum"
    lacks = "a moment that depends on the path of bending, not on its rate"
    cause = "any friction or hysteresis"
    citation = "W. D. Iwan, A distributed-element model for hysteresis, J. Appl. Mech. 33 (1966)"
    kind = "friction"
    flexible = True
    states = len(SLIPS)
    passive = True

    first: float = amplitude(0.03, "rad", lower=0.0, upper=1.0, description="level of the slider that slips at 0.03 rad")
    second: float = amplitude(0.03, "rad", lower=0.0, upper=1.0, description="level of the slider that slips at 0.12 rad")
    third: float = amplitude(0.03, "rad", lower=0.0, upper=1.0, description="level of the slider that slips at 0.4 rad")
    fourth: float = amplitude(0.03, "rad", lower=0.0, upper=1.0, description="level of the slider that slips at 1.2 rad")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        z = bending.memory
        some = p.first * z[0] / SLIPS[0] + p.second * z[1] / SLIPS[1]
        return bending.keq * (some + p.third * z[2] / SLIPS[2] + p.fourth * z[3] / SLIPS[3])

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        return limited(memory + (end - start), SLIPS[k])

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        levels = (self.first, self.second, self.third, self.fourth)
        return IMPLICIT * keq * sum(level / slip for level, slip in zip(levels, SLIPS, strict=True)), 0.0
