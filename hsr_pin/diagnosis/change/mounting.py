"""Changes of the mounting of the base and of the cameras, as effects that are fitted like any other.

They are not candidates in a single recording, where a rotated camera frame cannot be distinguished from a rotated base, and a
rotation about the arm's axis not from one of its actuators.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.effects.gravity_tilt import GravityTilt, seen_turned_in_plane
from hsr_pin.effects.spatial.base_tilt import BaseTilt, seen_turned, tilted
from hsr_pin.parameters import amplitude
from hsr_pin.robot.rotations import rotations
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

_CALIBRATION = "B. W. Mooring, Z. S. Roth, M. R. Driels, Fundamentals of Manipulator Calibration, Wiley (1991)"


@dataclass(frozen=True)
class FrameTurn(Effect):
    """p_seen = R(axis, angle) p: the camera frame is rotated in the plane, but gravity is not."""

    name = "frame_turn"
    lacks = "the camera frame is rotated"
    cause = "a new calibration"
    citation = _CALIBRATION
    kind = "measurement"
    in_space = False
    passive = True

    angle: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="rotation of the observed arm, to positive bending")

    def observe(self, view: View) -> Array:
        return seen_turned_in_plane(view, self.angle)


@dataclass(frozen=True)
class FrameRotation(Effect):
    """p_seen = R p, where R is a rotation vector in the axes of the base: :class:`FrameTurn` about any axis."""

    name = "frame_rotation"
    lacks = "the camera frame is rotated"
    cause = "a new calibration"
    citation = _CALIBRATION
    kind = "measurement"
    in_plane = False
    contains = ("frame_turn",)
    passive = True

    towards_x: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="rotation of the observed arm")
    towards_y: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="rotation of the observed arm")
    twist: float = amplitude(0.05, "rad", lower=-1.6, upper=1.6, description="from x towards y of the base")

    def observe(self, view: View) -> Array:
        return seen_turned(view, self.towards_x, self.towards_y, self.twist)


@dataclass(frozen=True)
class BaseRotation(Effect):
    """p_seen = R(line, twist) p with a tilted base: :class:`~hsr_pin.effects.spatial.base_tilt.BaseTilt` about any axis.

    ``line`` is the axis of a hanging or upright arm. Gravity acts along it and is not affected by a rotation about it. This does
    not hold for a horizontal arm, for which the law is not valid.
    """

    name = "base_rotation"
    lacks = "the base is not mounted as declared"
    cause = "mounting"
    citation = _CALIBRATION
    kind = "mass_gravity"
    in_plane = False
    contains = ("base_tilt",)
    passive = True

    towards_x: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="turn of the base")
    towards_y: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="turn of the base")
    twist: float = amplitude(0.05, "rad", lower=-1.6, upper=1.6, description="from x towards y of the base")

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        return tilted(specification, self.towards_x, self.towards_y)

    def observe(self, view: View) -> Array:
        places: Any = view.places
        up = np.sign(places.base[:, 2, 2])
        turn = rotations(np.stack(np.broadcast_arrays(0.0, 0.0, up * self.twist), axis=-1))
        return np.asarray((turn[:, None] @ view.positions[..., None])[..., 0])


def turns_cameras(effect: Effect | None) -> bool:
    """Return whether an effect is the law of a rotated camera frame under the name that it has in a single recording."""
    return isinstance(effect, GravityTilt | BaseTilt) and effect.frame == "cameras"


#: Name -> effect.
MOUNTING: dict[str, type[Effect]] = {effect.name: effect for effect in (FrameTurn, FrameRotation, BaseRotation)}
