"""Cause ``link_mass``: links heavier or lighter than declared, with moments of inertia in proportion."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class LinkMass(JointCause):
    """Links heavier or lighter than declared, with moments of inertia in proportion."""

    name = "link_mass"
    kind = "mass_gravity"
    description = "links heavier or lighter than declared, with moments of inertia in proportion"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the relative change of the mass of each link."""
        return tuple(amplitude(joint, 0.05, lower=-0.9, upper=5.0) for k, joint in enumerate(joints))

    def bodies(self, values: Values) -> Array:
        """Return the relative changes, (B, n)."""
        return values.of_joints()

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Scale mass and inertia of each link."""
        for joint, share in zip(joints, numbers, strict=True):
            k = model.getJointId(joint)
            own = model.inertias[k]
            model.inertias[k] = pin.Inertia((1 + share) * own.mass, own.lever, (1 + share) * own.inertia)
