"""Cause ``joint_stop``: soft stops at the ends of the range of the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values, joint_parameter
from hsr_pin.trajectory import Array

#: Depth over which a stop of practical size takes up the RMS torque [rad].
_DEPTH = 0.1


class JointStop(JointCause):
    """Soft stops at the ends of the range of the joints."""

    name = "joint_stop"
    kind = "contact"
    description = "soft stops at the ends of the range of the joints"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the stiffness of each joint's stops, and the distance of the stops from the extreme recorded angles."""
        stiffness = scales.torque / _DEPTH
        return (
            *(amplitude(joint_parameter("upper", joint), stiffness[k], "N m/rad", lower=0.0) for k, joint in enumerate(joints)),
            *(amplitude(joint_parameter("lower", joint), stiffness[k], "N m/rad", lower=0.0) for k, joint in enumerate(joints)),
            shape("before", 0.05, 0.005, 0.5, "rad"),
        )

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the torque that pushes the joints back from their stops."""
        above = np.maximum(now.q - (values.scales.max_angle - values.shared("before")), 0.0)
        below = np.maximum(values.scales.min_angle + values.shared("before") - now.q, 0.0)
        return values.of_joints("lower") * below - values.of_joints("upper") * above, np.zeros_like(now.v)
