"""Markers closer to the base, or to the tip, than declared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View, option
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class MarkerSlip(Effect):
    """Displacement of the markers along the backbone, towards the tip: p_measured = p + slip w(s) t.

    It is of first order in the slip, and exact on a straight link. ``which`` "outward": w = s, the relative arc length with
    respect to the outermost marker, as if a sleeve that carries the markers had slid. "between": w = 4 s (1 - s), the outermost
    marker is correct, as if the others had been misread. "all": w = 1, as if all had been measured from a point other than the
    base.
    """

    name = "marker_slip"
    lacks = "markers are not at their declared arc lengths"
    cause = "a sleeve that has slid, arc lengths that were misread"
    citation = "U. Della Croce et al., Human movement analysis using stereophotogrammetry. Part 4, Gait Posture 21 (2005)"
    kind = "measurement"
    passive = True

    slip: float = amplitude(
        0.005,
        "m",
        lower=-0.05,
        upper=0.05,
        description="displacement towards the tip, of the outermost marker, of one in the middle, or of all",
    )
    which: str = option("outward", "between", "all", description="markers that are displaced")

    def observe(self, view: View) -> Array:
        share = view.arc_lengths / np.max(view.arc_lengths, axis=-1, keepdims=True)
        weight = {"outward": share, "between": 4 * share * (1 - share), "all": np.ones_like(share)}[self.which]
        return np.asarray(view.positions + (np.asarray(self.slip)[..., None] * weight)[..., None] * view.tangents)
