"""A constant force across the arm at one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude, shape


@dataclass(frozen=True)
class SideForce(Effect):
    """Constant force at the arc length ``at``, normal to the straight arm, towards positive bending."""

    name = "side_force"
    lacks = "a constant force acts on the arm at one place"
    cause = "a hose or a cable that pulls, a rubber band"
    citation = "D. C. Rucker, R. J. Webster, Statics and dynamics of continuum robots with external loading, IEEE T-RO 27 (2011)"
    kind = "contact"
    in_space = False

    force: float = amplitude(0.2, "N", lower=-20.0, upper=20.0, description="force across the arm")
    at: float = shape(1.0, 0.1, "1", lower=0.2, upper=1.0, description="relative arc length at which it acts")

    @staticmethod
    def contact_force(p: Any, aside: Any) -> Any:
        return p.force + 0.0 * aside

    @staticmethod
    def place(p: Any) -> Any:
        return p.at
