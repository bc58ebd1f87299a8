"""An arm in space that is bent where no torque acts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class BendAtRest(Effect):
    """m = -k angle0: the springs are at ease when the whole arm is bent by the vector angle0, fixed in its base."""

    name = "bend_at_rest"
    lacks = "the arm at ease is bent towards one side"
    cause = "moulding, creep under its own weight, tendons and tubes that pull"
    citation = "D. Trivedi, A. Lotfi, C. D. Rahn, Geometrically exact models for soft robotic manipulators, IEEE TRO 24 (2008)"
    kind = "elastic"
    contains = ("preset_bend",)
    passive = True

    towards_x: float = parameter(
        0.0, lower=-1.5, upper=1.5, unit="rad", scale=0.05, amplitude=True, description="of the whole arm at ease"
    )
    towards_y: float = parameter(
        0.0, lower=-1.5, upper=1.5, unit="rad", scale=0.05, amplitude=True, description="of the whole arm at ease"
    )

    @property
    def in_plane(self) -> bool:
        return False

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -(p.towards_x + 1j * p.towards_y) * bending.keq * bending.stiffness + 0.0 * bending.angle
