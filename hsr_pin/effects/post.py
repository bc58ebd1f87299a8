"""A post beside the arm, across its plane, that the arm may touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.obstacles import CYLINDER, SILICONE, Surface, row
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array

#: Radius of the post [m]. Motions hardly depend on it: a thicker post acts like one that is closer to the arm.
RADIUS = 0.01


@dataclass(frozen=True)
class Post(Effect):
    """A post across the plane of a planar arm; the force is that of :class:`hsr_pin.obstacles.Surface`."""

    name = "post"
    lacks = "an obstacle beside the arm holds it back at one place"
    cause = "a post, an edge or a finger that it touches"
    citation = "K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact (1975)"
    kind = "contact"
    in_space = False
    passive = True

    hardness: float = amplitude(1e5, "N/m^2", lower=0.0, upper=3e6, description="force per depth and length in contact")
    gap: float = shape(
        0.02, 0.02, "m", lower=0.001, upper=0.3, start_count=4, description="gap between the straight arm and the post"
    )
    at: float = shape(0.7, 0.1, "1", lower=0.1, upper=1.2, description="relative arc length beside which the post is")
    friction: float = shape(0.0, 0.3, "1", lower=0.0, upper=1.5, start_count=1, description="coefficient of friction")
    side: str = option("positive", "negative", description="side of the post")

    def obstacle(self, length: Array, diameter: Array) -> Array:
        aside = (self.gap + RADIUS + diameter / 2) * (1.0 if self.side == "positive" else -1.0)
        centre = np.stack(np.broadcast_arrays(self.at * length, aside, 0.0), axis=-1)
        surface = Surface(self.hardness, SILICONE.dissipation, self.friction)
        return row(CYLINDER, centre, np.eye(3), (RADIUS, np.inf, 0.0), surface)
