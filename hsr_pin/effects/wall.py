"""A wall, a floor or a table that the arm may touch anywhere along its length."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.obstacles import HALF_SPACE, SILICONE, Surface, row
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Wall(Effect):
    """A half space across the plane of a planar arm; the force is that of :class:`hsr_pin.obstacles.Surface`."""

    name = "wall"
    lacks = "a flat obstacle holds the arm back"
    cause = "a wall, a floor or a table that it touches"
    citation = "K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact (1975)"
    kind = "contact"
    passive = True

    hardness: float = parameter(
        0.0, lower=0.0, upper=3e6, unit="N/m^2", scale=1e5, amplitude=True, description="force per depth and length in contact"
    )
    gap: float = parameter(
        0.02, lower=0.001, upper=0.3, unit="m", scale=0.02, start_count=4, description="gap between the straight arm and the wall"
    )
    angle: float = parameter(
        pi / 2,
        lower=-pi,
        upper=pi,
        unit="rad",
        scale=0.5,
        start_count=5,
        description="direction towards the wall: 0 along the straight arm, pi/2 towards positive bending",
    )
    friction: float = parameter(
        0.0, lower=0.0, upper=1.5, unit="1", scale=0.3, start_count=1, description="coefficient of friction"
    )

    @property
    def in_space(self) -> bool:
        return False

    def obstacle(self, length: Array, diameter: Array) -> Array:
        c, s = np.cos(self.angle), np.sin(self.angle)
        none, one = 0 * c, 0 * c + 1
        axes = np.stack([np.stack(each, axis=-1) for each in ((s, -c, none), (none, none, one), (-c, -s, none))], axis=-2)
        away = np.maximum(length * c, 0.0) + diameter / 2 + self.gap  # from the base
        centre = np.stack([away * c, away * s, none], axis=-1)
        return row(HALF_SPACE, centre, axes, np.zeros(3), Surface(self.hardness, SILICONE.dissipation, self.friction))
