"""The arm as a Pinocchio model: specification -> URDF text -> ``pin.Model``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from hsr_pin.robot.specification import ArmSpecification
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
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, pin.neutral(self.model))
        axis: Array = data.oMi[1].rotation @ np.array([0.0, 1.0, 0.0])
        return axis

    @property
    def direction(self) -> Array:
        """(3,) unit vector along the straight arm, from base to tip, in the world frame."""
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, pin.neutral(self.model))
        direction: Array = data.oMi[1].rotation @ np.array([0.0, 0.0, 1.0])
        return direction


@lru_cache(maxsize=4096)
def rigid_body(specification: ArmSpecification) -> ArmSpecification:
    """The same arm with the stiffness and damping of Table I: what its Pinocchio model depends on."""
    return replace(specification, keq=ArmSpecification.keq, damping=ArmSpecification.damping)


def build_model(specification: ArmSpecification) -> ArmModel:
    """Build the Pinocchio model of an arm from its URDF.

    Returns:
        A model with nq = nv = ``links`` revolute joints, gravity along -z, no armature.
    """
    return ArmModel(specification, _pinocchio_model(rigid_body(specification)))


@lru_cache(maxsize=256)
def _pinocchio_model(specification: ArmSpecification) -> pin.Model:
    return pin.buildModelFromXML(arm_to_urdf(specification))
