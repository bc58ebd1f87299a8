"""Markers off the backbone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View, option
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class MarkerOffset(Effect):
    """Offset of the markers across the backbone, towards positive bending: p_measured = p + offset n.

    ``base`` "kept": the marker at s = 0 has no offset. "zeroed": the cameras were zeroed with the arm in its first pose, and only
    later changes are visible: p + offset (n - n_first).
    """

    name = "marker_offset"
    lacks = "markers sit off the backbone's neutral line"
    cause = "marker plates"
    citation = "A. Leardini et al., Human movement analysis using stereophotogrammetry. Part 3, Gait Posture 21 (2005)"
    kind = "measurement"
    passive = True

    offset: float = amplitude(
        0.002, "m", lower=-0.05, upper=0.05, description="distance from the neutral line, towards positive bending"
    )
    base: str = option("moved", "kept", "zeroed", description="whether the marker at the base has the offset too")

    def observe(self, view: View) -> Array:
        if self.base == "zeroed":
            return np.asarray(view.positions + np.asarray(self.offset)[..., None, None] * (view.normals - view.normals[:1]))
        moved = (view.arc_lengths > 0) | (self.base == "moved")
        return np.asarray(view.positions + np.asarray(self.offset)[..., None, None] * moved[..., None] * view.normals)
