"""Cause ``link_inertia``: moments of inertia of the links larger or smaller than declared, at the same mass."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class LinkInertia(JointCause):
    """Moments of inertia of the links larger or smaller than declared, at the same mass."""

    name = "link_inertia"
    kind = "mass_gravity"
    description = "moments of inertia of the links larger or smaller than declared, at the same mass"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the relative change of the inertia of each link."""
        return tuple(amplitude(joint, 0.1, lower=-0.999, upper=10.0) for k, joint in enumerate(joints))

    def bodies(self, values: Values) -> Array:
        """Return the relative changes, (B, n)."""
        return values.of_joints()

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Scale the inertia of each link about its centre of mass."""
        for joint, share in zip(joints, numbers, strict=True):
            k = model.getJointId(joint)
            own = model.inertias[k]
            model.inertias[k] = pin.Inertia(own.mass, own.lever, (1 + share) * own.inertia)
