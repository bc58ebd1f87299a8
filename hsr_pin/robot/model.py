"""The arm as a Pinocchio model: specification -> URDF text -> ``pin.Model``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from hsr_pin.robot.specification import ArmSpecification, in_plane
from hsr_pin.robot.urdf import arm_to_urdf
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class ArmModel:
    """Rigid-body side of one arm. Springs and dampers are not in the Pinocchio model: the simulation adds them.

    Attributes:
        specification: the numbers it was made from.
        model: read-only by convention, shared between all users of the same specification; copy it before changing it.
    """

    specification: ArmSpecification
    model: pin.Model

    @property
    def joint_axis(self) -> Array:
        """(3,) unit vector of the joint axes in the world frame (they are all parallel)."""
        return self._base_rotation[:, 1]

    @property
    def direction(self) -> Array:
        """(3,) unit vector along the straight arm, from base to tip, in the world frame."""
        return self._base_rotation[:, 2]

    @property
    def normal(self) -> Array:
        """(3,) unit vector across the straight arm, towards positive bending, in the world frame."""
        return self._base_rotation[:, 0]

    @property
    def _base_rotation(self) -> Array:
        return np.array(self.model.jointPlacements[1].rotation)


@lru_cache(maxsize=4096)
def rigid_body(specification: ArmSpecification) -> ArmSpecification:
    """The same arm with the stiffness and damping of Table I: what its Pinocchio model depends on."""
    return replace(specification, keq=ArmSpecification.keq, damping=ArmSpecification.damping)


def build_model(specification: ArmSpecification) -> ArmModel:
    """Build the Pinocchio model of an arm from its URDF.

    Returns:
        A model with nq = nv = ``links`` revolute joints, gravity along -z, no armature.

    Raises:
        SpecificationError: the arm bends in space; see :func:`hsr_pin.robot.space.space_model`.
    """
    specification = in_plane(specification, "a chain of hinges")
    return ArmModel(specification, _pinocchio_model(rigid_body(specification)))


@lru_cache(maxsize=256)
def _pinocchio_model(specification: ArmSpecification) -> pin.Model:
    return pin.buildModelFromXML(arm_to_urdf(specification))
