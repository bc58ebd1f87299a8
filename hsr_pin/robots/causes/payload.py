"""Cause ``payload``: an undeclared mass on the last link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class Payload(JointCause):
    """An undeclared mass on the last link."""

    name = "payload"
    kind = "mass_gravity"
    description = "an undeclared mass on the last link"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the mass, and its distance from the last joint relative to that of the last link's centre of mass."""
        return (
            amplitude("mass", 0.05 * scales.mass, "kg", lower=0.0),
            shape("reach", 1.0, 0.0, 4.0),
        )

    def bodies(self, values: Values) -> Array:
        """Return mass and relative distance, (B, 2)."""
        return np.hstack([values.shared("mass"), values.shared("reach")])

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Add a point mass on the line from the last joint through the centre of mass of the last link."""
        mass, reach = numbers
        if mass:
            last = model.inertias[-1]
            model.inertias[-1] = last + pin.Inertia(float(mass), reach * last.lever, np.zeros((3, 3)))
