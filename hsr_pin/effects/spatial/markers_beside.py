"""Markers in space off the line on which they are declared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, View, option
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class MarkersBeside(Effect):
    """Offset of the markers in the axes of their links: p_measured = p + x n + y s.

    This is the spatial version of :class:`~hsr_pin.effects.marker_offset.MarkerOffset`.
    """

    name = "markers_beside"
    lacks = "markers sit off the backbone's neutral line"
    cause = "marker plates"
    citation = "A. Leardini et al., Human movement analysis using stereophotogrammetry. Part 3, Gait Posture 21 (2005)"
    kind = "measurement"
    in_plane = False
    contains = ("marker_offset",)
    passive = True

    towards_x: float = amplitude(0.002, "m", lower=-0.05, upper=0.05, description="offset from the declared position towards x")
    towards_y: float = amplitude(0.002, "m", lower=-0.05, upper=0.05, description="offset from the declared position towards y")
    base: str = option("moved", "kept", "zeroed", description="whether the marker at the base has the offset too")

    def observe(self, view: View) -> Array:
        places: Any = view.places
        x, y = (np.asarray(each)[..., None, None] for each in (self.towards_x, self.towards_y))
        way = x * view.normals + y * places.sides(view.angles)
        if self.base == "zeroed":
            return np.asarray(view.positions + (way - way[:1]))
        moved = (view.arc_lengths > 0) | (self.base == "moved")
        return np.asarray(view.positions + moved[..., None] * way)
