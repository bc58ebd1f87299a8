"""A tether that restrains the arm at one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Effect, option
from hsr_pin.effects.vector import chosen
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array

#: Depth over which a contact reaches its stiffness [m]; without a corner in the moment, fits find its position.
SOFT = 0.005


@dataclass(frozen=True)
class Restraint(Effect):
    """Elastic force at one place, on one side: f = -contact_stiffness max(|x| - distance, 0).

    x is the displacement from the line of the straight arm. The force increases as a parabola over the first 5 mm. A hard wall
    has a large stiffness.
    """

    name = "restraint"
    lacks = "beyond a distance something tied to the arm holds it back"
    cause = "a hose or a cable that goes taut, a rubber band"
    citation = "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983)"
    kind = "contact"
    in_space = False
    passive = True

    contact_stiffness: float = amplitude(20.0, "N/m", lower=0.0, upper=5000.0, description="stiffness of the contact")
    distance: float = shape(
        0.05,
        0.02,
        "m",
        lower=0.005,
        upper=0.3,
        start_count=6,  # a contact that the arm reaches only with its last millimetres is missed at other distances
        description="distance from the line of the straight arm to the contact",
    )
    at: float = shape(1.0, 0.1, "1", lower=0.2, upper=1.0, start_count=2, description="relative arc length of the contact")
    side: str = option("positive", "negative", description="side of the contact")

    @staticmethod
    def contact_force(p: Any, aside: Any) -> Any:
        towards = chosen(p.side == 0, 1.0, -1.0)
        depth = np.maximum(towards * aside - p.distance, 0.0)
        soft = np.minimum(depth, SOFT)
        return -p.contact_stiffness * towards * soft / SOFT * (depth - soft / 2)

    @staticmethod
    def place(p: Any) -> Any:
        return p.at

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        # slope at the base, for a nearly straight arm of uniform curvature: the lever is the arc length of the contact, and the
        # contact point moves by half of this length times the bending angle up to it
        return IMPLICIT * self.contact_stiffness * (self.at * length) ** 2 / 2 * self.at, 0.0
