"""A mass at the end of the last link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class Payload(JointCause):
    """A mass at the end of the last link."""

    name = "payload"
    kind = "mass_gravity"
    description = "a mass at the end of the last link"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """The mass, and how far from the last joint along the link it is, over where its centre of mass is."""
        return (
            amplitude("mass", 0.05 * sizes.mass, "kg", lower=0.0),
            shape("reach", 1.0, 0.0, 4.0),
        )

    def bodies(self, values: Values) -> Array:
        """The mass, and its reach."""
        return np.hstack([values.shared("mass"), values.shared("reach")])

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """A point on the line from the last joint through the centre of mass of the last link."""
        mass, reach = numbers
        if mass:
            last = model.inertias[-1]
            model.inertias[-1] = last + pin.Inertia(float(mass), reach * last.lever, np.zeros((3, 3)))
