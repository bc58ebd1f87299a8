"""Cameras with a wrong length scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class CameraScale(Effect):
    """Measured positions that are scaled by a constant factor: p_measured = (1 + scale) p."""

    name = "camera_scale"
    lacks = "the cameras measure all lengths too large or too small by one factor"
    cause = "a calibration with a wand of another length"
    citation = "L. Chiari et al., Human movement analysis using stereophotogrammetry. Part 2, Gait Posture 21 (2005)"
    kind = "measurement"
    passive = True

    scale: float = amplitude(0.01, "1", lower=-0.3, upper=0.3, description="relative error of measured lengths")

    def observe(self, view: View) -> Array:
        return np.asarray(view.positions * (1 + np.asarray(self.scale)[..., None, None]))
