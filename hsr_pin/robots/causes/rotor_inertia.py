"""Inertia of the motors at the joints."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class RotorInertia(JointCause):
    """Inertia of the motors at the joints."""

    name = "rotor_inertia"
    kind = "mass_gravity"
    description = "inertia of the motors at the joints"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """An inertia of each joint."""
        return tuple(amplitude(joint, 0.05 * sizes.inertia[k], "kg m^2", lower=0.0) for k, joint in enumerate(joints))

    def armature(self, values: Values) -> Array:
        """At the joints."""
        return values.of_joints()
