"""An arm in space that is bent without torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class BendAtRest(Effect):
    """Bending of the relaxed arm by a vector angle0 that is fixed in its base: m = -k angle0."""

    name = "bend_at_rest"
    lacks = "the relaxed arm is bent towards one side"
    cause = "moulding, creep under its own weight, tendons and tubes that pull"
    citation = "D. Trivedi, A. Lotfi, C. D. Rahn, Geometrically exact models for soft robotic manipulators, IEEE TRO 24 (2008)"
    kind = "elastic"
    in_plane = False
    contains = ("preset_bend",)
    passive = True

    towards_x: float = amplitude(0.05, "rad", lower=-1.5, upper=1.5, description="bending of the whole relaxed arm towards x")
    towards_y: float = amplitude(0.05, "rad", lower=-1.5, upper=1.5, description="bending of the whole relaxed arm towards y")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -(p.towards_x + 1j * p.towards_y) * bending.keq * bending.stiffness + 0.0 * bending.angle
