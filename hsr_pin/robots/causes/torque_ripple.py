"""Cause ``torque_ripple``: a torque that is periodic in the angle of the joints, such as cogging."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values, joint_parameter
from hsr_pin.trajectory import Array


class TorqueRipple(JointCause):
    """A torque that is periodic in the angle of the joints, such as cogging."""

    name = "torque_ripple"
    kind = "actuation_map"
    description = "a torque that is periodic in the angle of the joints, such as cogging"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the cosine and sine amplitudes of each joint, and the number of periods per turn."""
        return (
            *(amplitude(joint_parameter("cosine", joint), 0.05 * scales.torque[k], "N m") for k, joint in enumerate(joints)),
            *(amplitude(joint_parameter("sine", joint), 0.05 * scales.torque[k], "N m") for k, joint in enumerate(joints)),
            shape("per_turn", 6.0, 1.0, 40.0),
        )

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the periodic torque; it adds no damping."""
        angle = values.shared("per_turn") * now.q
        return values.of_joints("cosine") * np.cos(angle) + values.of_joints("sine") * np.sin(angle), np.zeros_like(now.v)
