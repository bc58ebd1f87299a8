"""Obstacles and the forces that they exert on an arm, as objects of the viewer."""

from __future__ import annotations

from typing import Any

import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np

from hsr_pin.obstacles import Box, Cylinder, HalfSpace, Obstacle, Sphere
from hsr_pin.trajectory import Array

#: Colours 0xRRGGBB of obstacles and of forces.
COLOUR, FORCE = 0xB9A88F, 0xC0392B
#: Thickness of the plate that is drawn for a half space, and length of the largest force, relative to the extent of the scene.
_PLATE, _LONGEST = 0.03, 0.3


def shape(obstacle: Obstacle, extent: float) -> tuple[Any, Array]:
    """Return the geometry and the placement (4, 4) of an obstacle in a scene that extends over ``extent`` [m].

    A half space is drawn as a plate, and an infinite cylinder as one that is as long as the scene.
    """
    row = obstacle.row()
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = row[4:13].reshape(3, 3).T, row[1:4]
    if isinstance(obstacle, Sphere):
        return mg.Sphere(obstacle.radius), place
    if isinstance(obstacle, Cylinder):  # the viewer's cylinders are along y
        return mg.Cylinder(min(obstacle.length, extent), obstacle.radius), place @ mt.rotation_matrix(np.pi / 2, [1, 0, 0])
    if isinstance(obstacle, Box):
        return mg.Box(obstacle.size), place
    assert isinstance(obstacle, HalfSpace)
    thick = _PLATE * extent
    return mg.Box((2 * extent, 2 * extent, thick)), place @ mt.translation_matrix([0, 0, -thick / 2])


def arrows(force: Array, point: Array, extent: float) -> tuple[Array, Array]:
    """Return start and end (T, O, 3) [m] of arrows for forces (T, O, 3) [N] at points (T, O, 3) [m]; NaN without contact."""
    largest = np.linalg.norm(force, axis=2).max(initial=0.0)
    return point, point + force * (_LONGEST * extent / largest if largest > 0 else 0.0)
