"""Markers in space from motions of the arm."""

from __future__ import annotations

import cmath
from collections.abc import Sequence

import numpy as np

from ..arm import Array
from ..laws.law import Law
from ..writing import Marker, filmed
from .arm import SpaceArm, SpaceMotion

#: Markers at the base, in the middle, and two at the tip, one of them at a distance from the backbone.
MARKERS = (
    Marker("base", 0.0),
    Marker("mid", 0.12),
    Marker("tip", 0.24),
    Marker("side", 0.24, 0.03, 0.7),
)


def observe(motion: SpaceMotion, arm: SpaceArm, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
    """Return marker points (T, M, 3) in the world [m], without noise.

    Args:
        motion: motion of the arm.
        arm: the true arm.
        laws: laws, some of which may move markers or cameras.
        markers: M markers.
        error: (M, 2) error of each marker's place, along and off the backbone [m].
    """
    beside = sum(getattr(law, "beside", 0.0) for law in laws)
    points = [
        motion.at(
            float(np.clip(marker.arc_length + along, 0.0, arm.length)), cmath.rect(marker.radius, marker.angle) + off + beside
        )
        for marker, (along, off) in zip(markers, error, strict=True)
    ]
    return filmed(np.stack(points, axis=1) @ arm.frame(seen=True).T, laws)
