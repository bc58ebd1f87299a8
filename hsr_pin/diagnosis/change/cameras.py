"""What may be another in how an arm is seen, though the arm is the same: as effects, so that they are tried like any other.

They are no candidates of a single recording: there a frame that is turned is a base that is turned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.effects.gravity_tilt import GravityTilt
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class FrameTurn(Effect):
    """p_seen = R(axis, angle) p: the cameras' frame is turned in the plane, and gravity is not."""

    name = "frame_turn"
    lacks = "the cameras' frame is turned"
    cause = "a new calibration"
    citation = "B. W. Mooring, Z. S. Roth, M. R. Driels, Fundamentals of Manipulator Calibration, Wiley (1991)"
    kind = "measurement"
    passive = True

    angle: float = parameter(
        0.0, lower=-0.8, upper=0.8, unit="rad", scale=0.05, amplitude=True, description="of the arm as seen, to positive bending"
    )

    def observe(self, view: View) -> Array:
        p, axis, angle = view.positions, view.axis, np.asarray(self.angle)[..., None, None]
        along = axis * (p @ axis)[..., None]  # Rodrigues' formula
        return np.asarray(p * np.cos(angle) + np.cross(axis, p) * np.sin(angle) + along * (1 - np.cos(angle)))


def turns_cameras(effect: Effect | None) -> bool:
    """Whether it is the law of :class:`FrameTurn` under the name that it has in a single recording."""
    return isinstance(effect, GravityTilt) and effect.frame == "cameras"


#: By name.
CAMERAS: dict[str, type[Effect]] = {effect.name: effect for effect in (FrameTurn,)}
