"""Markers in space from motions, and datasets in the recording format, version 2."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm import Array
from ..laws.law import Law
from ..writing import Marker
from .arm import SpaceArm, SpaceMotion


@dataclass(frozen=True)
class SpaceMarker(Marker):
    """A tracked point beside the backbone, by radius [m], at an angle from x towards y of its section [rad]."""

    radius: float = 0.0
    angle: float = 0.0

    @classmethod
    def of(cls, marker: Marker) -> SpaceMarker:
        """Any marker as one in space."""
        return marker if isinstance(marker, cls) else cls(marker.name, marker.arc_length)

    @property
    def beside(self) -> complex:
        """From the backbone, x + i y [m]."""
        return cmath.rect(self.radius, self.angle)


#: At the base, in the middle, and two at the tip, of which one stands out.
MARKERS = (
    SpaceMarker("base", 0.0),
    SpaceMarker("mid", 0.12),
    SpaceMarker("tip", 0.24),
    SpaceMarker("side", 0.24, 0.03, 0.7),
)


def observe(motion: SpaceMotion, arm: SpaceArm, laws: Sequence[Law], markers: Sequence[SpaceMarker], error: Array) -> Array:
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
        motion.at(float(np.clip(marker.arc_length + along, 0.0, arm.length)), marker.beside + off + beside)
        for marker, (along, off) in zip(markers, error, strict=True)
    ]
    seen = np.stack(points, axis=1) @ arm.frame(seen=True).T
    for law in laws:
        seen = law.seen(seen)
    return np.asarray(seen)
