"""A wall, a floor or a table that the arm may touch anywhere along its length."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.obstacles import HALF_SPACE, SILICONE, Surface, row
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Wall(Effect):
    """A half space across the plane of a planar arm; the force is that of :class:`hsr_pin.obstacles.Surface`."""

    name = "wall"
    lacks = "a flat obstacle holds the arm back"
    cause = "a wall, a floor or a table that it touches"
    citation = "K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact (1975)"
    kind = "contact"
    in_space = False
    passive = True

    hardness: float = amplitude(1e5, "N/m^2", lower=0.0, upper=3e6, description="force per depth and length in contact")
    gap: float = shape(
        0.02, 0.02, "m", lower=0.001, upper=0.3, start_count=4, description="gap between the straight arm and the wall"
    )
    angle: float = shape(
        pi / 2,
        0.5,
        "rad",
        lower=-pi,
        upper=pi,
        start_count=5,
        description="direction towards the wall: 0 along the straight arm, pi/2 towards positive bending",
    )
    friction: float = shape(0.0, 0.3, "1", lower=0.0, upper=1.5, start_count=1, description="coefficient of friction")

    def obstacle(self, length: Array, diameter: Array) -> Array:
        c, s = np.cos(self.angle), np.sin(self.angle)
        none, one = 0 * c, 0 * c + 1
        axes = np.stack([np.stack(each, axis=-1) for each in ((s, -c, none), (none, none, one), (-c, -s, none))], axis=-2)
        away = np.maximum(length * c, 0.0) + diameter / 2 + self.gap  # from the base
        centre = np.stack([away * c, away * s, none], axis=-1)
        return row(HALF_SPACE, centre, axes, np.zeros(3), Surface(self.hardness, SILICONE.dissipation, self.friction))
