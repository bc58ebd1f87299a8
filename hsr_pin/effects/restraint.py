"""Something beside the arm that holds it back at one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Effect, option
from hsr_pin.effects.vector import chosen
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array

#: [m] Depth over which a contact comes up to its stiffness: without a corner in its moment, fits find its place.
SOFT = 0.005


@dataclass(frozen=True)
class Restraint(Effect):
    """f = -contact_stiffness max(|x| - distance, 0) at one place, on one side, x from the line of the straight arm; no friction.

    It sets in softly, as a parabola over the first 5 mm. A hard wall is one of large stiffness.
    """

    name = "restraint"
    lacks = "beyond a distance something holds the arm back"
    cause = "a wall, a post or a table that it touches, a hose that goes taut"
    citation = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983)"
    kind = "contact"
    passive = True

    contact_stiffness: float = parameter(
        0.0, lower=0.0, upper=5000.0, unit="N/m", scale=20.0, amplitude=True, description="of what holds it"
    )
    distance: float = parameter(
        0.05,
        lower=0.005,
        upper=0.3,
        unit="m",
        scale=0.02,
        looks=6,  # one that an arm meets with its last few millimetres is met at no distance much smaller or larger
        description="from the line of the straight arm to where it begins",
    )
    at: float = parameter(
        1.0, lower=0.2, upper=1.0, unit="1", scale=0.1, looks=2, description="arc length over L of the place that it holds"
    )
    side: str = option("positive", "negative", description="towards which bending it stands")

    @property
    def in_space(self) -> bool:
        return False

    @staticmethod
    def touch(p: Any, aside: Any) -> Any:
        towards = chosen(p.side == 0, 1.0, -1.0)
        depth = np.maximum(towards * aside - p.distance, 0.0)
        soft = np.minimum(depth, SOFT)
        return -p.contact_stiffness * towards * soft / SOFT * (depth - soft / 2)

    @staticmethod
    def place(p: Any) -> Any:
        return p.at

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        # of an arm that is nearly straight and bends evenly, at the base: the lever is as long as the place is far, and that
        # moves by half of this length times the angle of the arm up to it
        return IMPLICIT * self.contact_stiffness * (self.at * length) ** 2 / 2 * self.at, 0.0
