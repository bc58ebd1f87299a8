"""Markers in space from motions."""

from __future__ import annotations

import cmath
from collections.abc import Sequence

import numpy as np

from ..arm import Array
from ..laws.law import Law
from ..writing import Marker, filmed
from .arm import SpaceArm, SpaceMotion

#: At the base, in the middle, and two at the tip, of which one stands out.
MARKERS = (
    Marker("base", 0.0),
    Marker("mid", 0.12),
    Marker("tip", 0.24),
    Marker("side", 0.24, 0.03, 0.7),
)


def observe(motion: SpaceMotion, arm: SpaceArm, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
    """Marker points (T, M, 3) in the world [m], without noise.

    Args:
        motion: of the arm.
        arm: as it truly is.
        laws: which may move markers or cameras.
        markers: M of them.
        error: (M, 2) how far each marker sits from where it should, along and off the backbone [m].
    """
    beside = sum(getattr(law, "beside", 0.0) for law in laws)
    points = [
        motion.at(
            float(np.clip(marker.arc_length + along, 0.0, arm.length)), cmath.rect(marker.radius, marker.angle) + off + beside
        )
        for marker, (along, off) in zip(markers, error, strict=True)
    ]
    return filmed(np.stack(points, axis=1) @ arm.frame(seen=True).T, laws)
