"""Markers off the backbone, each with its own offset, that move along it as the arm bends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class MarkerProfile(Effect):
    """Marker offsets that vary along the arm and with bending: p_measured = p + o n + slide theta t.

    The offset is o = across + taper x + lift theta. n and t are normal and tangent of the backbone at a marker, theta is the
    angle there from the base, and x increases from -1 at the base to 1 at the outermost marker.
    """

    name = "marker_profile"
    lacks = "every marker has its own offset from the backbone and moves along it as the arm bends"
    cause = "plates and sleeves that differ, lift off and slide"
    citation = "A. Leardini et al., Human movement analysis using stereophotogrammetry. Part 3, Gait Posture 21 (2005)"
    kind = "measurement"
    in_space = False
    passive = True
    flexible = True

    across: float = amplitude(0.002, "m", lower=-0.05, upper=0.05, description="mean offset from the neutral line")
    taper: float = amplitude(0.002, "m", lower=-0.05, upper=0.05, description="increase of the offset towards the tip")
    lift: float = amplitude(0.002, "m/rad", lower=-0.05, upper=0.05, description="offset per bending up to the marker")
    slide: float = amplitude(
        0.002, "m/rad", lower=-0.05, upper=0.05, description="displacement along the arm per bending up to the marker"
    )

    def observe(self, view: View) -> Array:
        across, taper, lift, slide = (np.asarray(each)[..., None] for each in (self.across, self.taper, self.lift, self.slide))
        x = 2 * view.arc_lengths / np.max(view.arc_lengths, axis=-1, keepdims=True) - 1
        beside = (across + taper * x + lift * view.turned)[..., None]
        return np.asarray(view.positions + beside * view.normals + (slide * view.turned)[..., None] * view.tangents)
