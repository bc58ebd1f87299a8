"""An obstacle that the arm touches: a post beside it, or a wall or a floor in any direction of its plane."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.obstacles import CYLINDER, HALF_SPACE, SILICONE, Surface, row
from hsr_pin.parameters import amplitude, shape
from hsr_pin.trajectory import Array

#: Radius of a post [m]. Motions hardly depend on it: a thicker post acts like one that is closer to the arm.
RADIUS = 0.01


@dataclass(frozen=True)
class Obstacle(Effect):
    """A post or a half space that a planar arm of its diameter touches; the force is that of :mod:`hsr_pin.simulation.contact`.

    A post stands beside the relative arc length ``at`` of the straight arm. The direction from the base towards a wall is
    turned by pi (1 - at) from the straight arm to the ``side``: a wall at 0.5 is parallel to the arm, and one at 1 is a floor
    below the tip of a hanging arm. Both leave a ``gap`` to the surface of the straight arm.
    """

    name = "obstacle"
    lacks = "it touches an obstacle"
    cause = "a wall, a floor, a table, a post or a finger beside the arm"
    citation = "K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact (1975)"
    kind = "contact"
    in_space = False
    passive = True

    hardness: float = amplitude(1e4, "N/m^2", lower=0.0, upper=3e6, description="force per depth and length in contact")
    gap: float = shape(
        0.02, 0.02, "m", lower=0.001, upper=0.3, start_count=4, description="gap between the straight arm and the obstacle"
    )
    at: float = shape(0.7, 0.1, "1", lower=0.1, upper=1.1, description="arc length of a post, or direction of a wall")
    friction: float = shape(0.0, 0.3, "1", lower=0.0, upper=1.5, start_count=1, description="coefficient of friction")
    form: str = option("post", "wall", description="shape of the obstacle")
    side: str = option("positive", "negative", description="side of the arm")

    def obstacle(self, length: Array, diameter: Array) -> Array:
        side = 1.0 if self.side == "positive" else -1.0
        surface = Surface(self.hardness, SILICONE.dissipation, self.friction)
        if self.form == "post":
            aside = side * (self.gap + RADIUS + diameter / 2)
            centre = np.stack(np.broadcast_arrays(self.at * length, aside, 0.0), axis=-1)
            return row(CYLINDER, centre, np.eye(3), (RADIUS, np.inf, 0.0), surface)
        turn = pi * (1 - np.asarray(self.at))
        c, s, none = np.cos(turn), side * np.sin(turn), 0.0 * turn
        axes = np.stack([np.stack(each, axis=-1) for each in ((s, -c, none), (none, none, none + 1), (-c, -s, none))], axis=-2)
        away = np.maximum(length * c, 0.0) + diameter / 2 + self.gap  # from the base
        return row(HALF_SPACE, np.stack([away * c, away * s, none * away], axis=-1), axes, np.zeros(3), surface)
