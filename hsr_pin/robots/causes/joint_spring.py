"""Cause ``joint_spring``: springs at the joints, such as the stiffness of cables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values, joint_parameter
from hsr_pin.trajectory import Array


class JointSpring(JointCause):
    """Springs at the joints, such as the stiffness of cables."""

    name = "joint_spring"
    kind = "elastic"
    description = "springs at the joints, such as the stiffness of cables"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the stiffness of each joint, and the torque of its spring at the angle 0."""
        stiffness = 0.1 * scales.torque / scales.angle
        return (
            *(
                amplitude(joint_parameter("stiffness", joint), stiffness[k], "N m/rad", lower=0.0)
                for k, joint in enumerate(joints)
            ),
            *(amplitude(joint_parameter("pull", joint), 0.1 * scales.torque[k], "N m") for k, joint in enumerate(joints)),
        )

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the torque of the springs; they add no damping."""
        return values.of_joints("pull") - values.of_joints("stiffness") * now.q, np.zeros_like(now.v)
