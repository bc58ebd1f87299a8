"""Damping that varies along the arm."""

from __future__ import annotations

from dataclasses import dataclass

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class DampingGradient(Effect):
    """Linear variation of the damping along the arm with a constant mean C: c(s) / C = 1 + slope (s - 1/2)."""

    name = "damping_gradient"
    lacks = "damping varies from base to tip"
    cause = "tubes, muscle ends"
    citation = "H. T. Banks, D. J. Inman, On damping mechanisms in beams, J. Appl. Mech. 58 (1991)"
    kind = "damping"
    passive = True

    slope: float = amplitude(
        0.3, "1", lower=-1.98, upper=1.98, description="damping at the tip minus damping at the base, relative to the middle"
    )

    def damping(self, s: Array) -> Array:
        return 1 + self.slope * (s - 0.5)
