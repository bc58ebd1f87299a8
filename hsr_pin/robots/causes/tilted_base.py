"""A base that does not stand as declared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class TiltedBase(JointCause):
    """A base that does not stand as declared."""

    name = "tilted_base"
    kind = "mass_gravity"
    description = "a base that does not stand as declared"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """The angles by which it is turned about its x and its y axis."""
        return (
            amplitude("about_x", 0.03, "rad", lower=-1.0, upper=1.0),
            amplitude("about_y", 0.03, "rad", lower=-1.0, upper=1.0),
        )

    def bodies(self, values: Values) -> Array:
        """The angles."""
        return np.hstack([values.shared("about_x"), values.shared("about_y")])

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Gravity, as the base sees it."""
        model.gravity.linear = pin.exp3(np.array([*numbers, 0.0])).T @ model.gravity.linear
