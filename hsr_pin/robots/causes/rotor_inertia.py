"""Cause ``rotor_inertia``: undeclared inertia of the motors."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class RotorInertia(JointCause):
    """Undeclared inertia of the motors."""

    name = "rotor_inertia"
    kind = "mass_gravity"
    description = "undeclared inertia of the motors"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the inertia of each motor, reflected to its joint."""
        return tuple(amplitude(joint, 0.05 * scales.inertia[k], "kg m^2", lower=0.0) for k, joint in enumerate(joints))

    def armature(self, values: Values) -> Array:
        """Return the added inertia, (B, n) [kg m^2]."""
        return values.of_joints()
