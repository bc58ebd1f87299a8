"""A base in space that is not mounted as declared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import Effect, View, option
from hsr_pin.parameters import amplitude
from hsr_pin.robot.rotations import rotations, vectors
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class BaseTilt(Effect):
    """Rotation of the base about any axis across the arm, relative to gravity.

    This is the spatial version of :class:`~hsr_pin.effects.gravity_tilt.GravityTilt`.
    """

    name = "base_tilt"
    lacks = "the base is not mounted as declared"
    cause = "mounting"
    citation = "B. W. Mooring, Z. S. Roth, M. R. Driels, Fundamentals of Manipulator Calibration, Wiley (1991)"
    kind = "mass_gravity"
    in_plane = False
    contains = ("gravity_tilt",)
    passive = True

    towards_x: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="rotation of the base towards x")
    towards_y: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="rotation of the base towards y")
    frame: str = option("world", "base", "cameras", description="body that the markers' frame is fixed to")

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        if self.frame == "cameras":
            return specification
        return tilted(specification, self.towards_x, self.towards_y)

    def observe(self, view: View) -> Array:
        if self.frame == "world":
            return view.positions
        way = 1.0 if self.frame == "cameras" else -1.0
        return seen_turned(view, way * np.asarray(self.towards_x), way * np.asarray(self.towards_y))


def tilted(arm: ArmSpecification, towards_x: float, towards_y: float) -> ArmSpecification:
    """Return an arm whose base is rotated in addition, towards x and towards y [rad]."""
    return replace(arm, tilt=arm.tilt + towards_x, cross_tilt=arm.cross_tilt + towards_y)


def seen_turned(view: View, towards_x: ArrayLike, towards_y: ArrayLike, twist: ArrayLike = 0.0) -> Array:
    """Return marker positions (T, B, M, 3) [m] rotated by rotation vectors in the axes of the base, (B,) or one for all [rad]."""
    places: Any = view.places
    turn = rotations(vectors(np.stack(np.broadcast_arrays(towards_x, towards_y, twist), axis=-1)))
    back = places.base @ turn @ np.swapaxes(places.base, -1, -2)
    return np.asarray((back[..., None, :, :] @ view.positions[..., None])[..., 0])
