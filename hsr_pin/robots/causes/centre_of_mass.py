"""Cause ``centre_of_mass``: centres of mass farther from the joints, or nearer, than declared."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class CentreOfMass(JointCause):
    """Centres of mass farther from the joints, or nearer, than declared."""

    name = "centre_of_mass"
    kind = "mass_gravity"
    description = "centres of mass farther from the joints, or nearer, than declared"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the relative change of the distance of each link's centre of mass from its joint."""
        return tuple(amplitude(joint, 0.05, lower=-0.9, upper=5.0) for k, joint in enumerate(joints))

    def bodies(self, values: Values) -> Array:
        """Return the relative changes, (B, n)."""
        return values.of_joints()

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Move the centres of mass along the line from the joint of each link."""
        for joint, share in zip(joints, numbers, strict=True):
            k = model.getJointId(joint)
            own = model.inertias[k]
            model.inertias[k] = pin.Inertia(own.mass, (1 + share) * own.lever, own.inertia)
