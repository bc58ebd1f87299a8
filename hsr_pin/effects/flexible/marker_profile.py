"""Markers that sit beside the backbone, each in its own way, and move on it as the arm bends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class MarkerProfile(Effect):
    """p_seen = p + (across + taper x + lift theta) n + slide theta t.

    n and t across and along the backbone at a marker, theta the angle there from the base, x from -1 at the base to 1 at the
    outermost marker.
    """

    name = "marker_profile"
    lacks = "every marker sits beside the backbone in its own way, and moves on it as the arm bends"
    cause = "plates and sleeves that differ, lift off and slide"
    citation = "A. Leardini et al., Human movement analysis using stereophotogrammetry. Part 3, Gait Posture 21 (2005)"
    kind = "measurement"
    passive = True
    flexible = True

    across: float = parameter(
        0.0, lower=-0.05, upper=0.05, unit="m", scale=0.002, amplitude=True, description="from the neutral line"
    )
    taper: float = parameter(
        0.0, lower=-0.05, upper=0.05, unit="m", scale=0.002, amplitude=True, description="more of it at the tip"
    )
    lift: float = parameter(
        0.0, lower=-0.05, upper=0.05, unit="m/rad", scale=0.002, amplitude=True, description="across, with the angle there"
    )
    slide: float = parameter(
        0.0, lower=-0.05, upper=0.05, unit="m/rad", scale=0.002, amplitude=True, description="along, with the angle there"
    )

    @property
    def in_space(self) -> bool:
        return False

    def observe(self, view: View) -> Array:
        across, taper, lift, slide = (np.asarray(each)[..., None] for each in (self.across, self.taper, self.lift, self.slide))
        x = 2 * view.arc_lengths / np.max(view.arc_lengths, axis=-1, keepdims=True) - 1
        beside = (across + taper * x + lift * view.turned)[..., None]
        return np.asarray(view.positions + beside * view.normals + (slide * view.turned)[..., None] * view.tangents)
