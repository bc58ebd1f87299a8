"""The arm as a Pinocchio model: specification -> URDF text -> ``pin.Model``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from hsr_pin.robot.chain import GRAVITY
from hsr_pin.robot.specification import ArmSpecification, gravity_direction, in_plane
from hsr_pin.robot.urdf import arm_to_urdf
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class ArmModel:
    """The rigid-body model of one arm, without springs and dampers, which the simulation adds.

    Attributes:
        specification: the specification of the arm.
        model: the Pinocchio model, shared between all users of the same specification; copy it before changing it.
    """

    specification: ArmSpecification
    model: pin.Model

    @property
    def joint_axis(self) -> Array:
        """Unit vector (3,) of the joint axes in the world frame (they are all parallel)."""
        return self._base_rotation[:, 1]

    @property
    def direction(self) -> Array:
        """Unit vector (3,) along the straight arm, from base to tip, in the world frame."""
        return self._base_rotation[:, 2]

    @property
    def normal(self) -> Array:
        """Unit vector (3,) across the straight arm, towards positive bending, in the world frame."""
        return self._base_rotation[:, 0]

    @property
    def _base_rotation(self) -> Array:
        return np.array(self.model.jointPlacements[1].rotation)


@lru_cache(maxsize=4096)
def rigid_body(specification: ArmSpecification) -> ArmSpecification:
    """Return the arm without obstacles, with the stiffness and damping of Table I: its Pinocchio model depends on neither."""
    return replace(specification, keq=ArmSpecification.keq, damping=ArmSpecification.damping, obstacles=())


def build_model(specification: ArmSpecification) -> ArmModel:
    """Build the Pinocchio model of an arm from its URDF.

    Returns:
        A model with nq = nv = ``links`` revolute joints, gravity along -z (across the plane of a flat arm), no armature.

    Raises:
        SpecificationError: the arm bends in space; see :func:`hsr_pin.robot.space.space_model`.
    """
    specification = in_plane(specification, "a chain of hinges")
    return ArmModel(specification, _pinocchio_model(rigid_body(specification)))


@lru_cache(maxsize=256)
def _pinocchio_model(specification: ArmSpecification) -> pin.Model:
    model = pin.buildModelFromXML(arm_to_urdf(specification))
    model.gravity.linear = GRAVITY * gravity_direction(specification.mount)
    return model
