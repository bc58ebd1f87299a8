"""Cause ``tilted_base``: a base that is tilted from its declared orientation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class TiltedBase(JointCause):
    """A base that is tilted from its declared orientation."""

    name = "tilted_base"
    kind = "mass_gravity"
    description = "a base that is tilted from its declared orientation"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the angles of the tilt about the x and the y axis of the base."""
        return (
            amplitude("about_x", 0.03, "rad", lower=-1.0, upper=1.0),
            amplitude("about_y", 0.03, "rad", lower=-1.0, upper=1.0),
        )

    def bodies(self, values: Values) -> Array:
        """Return the two angles, (B, 2) [rad]."""
        return np.hstack([values.shared("about_x"), values.shared("about_y")])

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Rotate gravity into the frame of the tilted base."""
        model.gravity.linear = pin.exp3(np.array([*numbers, 0.0])).T @ model.gravity.linear
