"""A base that is not mounted as declared."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import Effect, View, option
from hsr_pin.parameters import amplitude
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class GravityTilt(Effect):
    """The base is rotated in the plane of bending, towards positive bending, relative to gravity.

    ``frame`` is the body that the markers' frame is fixed to. "world": the whole arm is measured as rotated. "base": the frame is
    rotated with the arm (the cameras were calibrated on it), and only gravity appears rotated, p_measured = R(axis, -angle) p.
    "cameras": only the cameras are rotated, by -angle, and the base is mounted as declared: p_measured = R(axis, angle) p.
    """

    name = "gravity_tilt"
    lacks = "the base is not mounted as declared"
    cause = "mounting"
    citation = "B. W. Mooring, Z. S. Roth, M. R. Driels, Fundamentals of Manipulator Calibration, Wiley (1991)"
    kind = "mass_gravity"
    passive = True

    angle: float = amplitude(0.05, "rad", lower=-0.8, upper=0.8, description="rotation of the base in the plane")
    frame: str = option("world", "base", "cameras", description="body that the markers' frame is fixed to")

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        if self.frame == "cameras":
            return specification
        return replace(specification, tilt=np.mod(specification.tilt + self.angle + np.pi, 2 * np.pi) - np.pi)

    def observe(self, view: View) -> Array:
        if self.frame == "world":
            return view.positions
        return seen_turned_in_plane(view, self.angle if self.frame == "cameras" else -np.asarray(self.angle))


def seen_turned_in_plane(view: View, turn: ArrayLike) -> Array:
    """Return marker positions (T, B, M, 3) [m] rotated about the joint axis by angles, (B,) or one for all [rad]."""
    p, axis, angle = view.positions, view.axis, np.asarray(turn)[..., None, None]
    along = axis * (p @ axis)[..., None]  # Rodrigues' formula
    return np.asarray(p * np.cos(angle) + np.cross(axis, p) * np.sin(angle) + along * (1 - np.cos(angle)))
