"""Cause ``stribeck_friction``: friction of the joints that is higher near standstill."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values, joint_parameter
from hsr_pin.robots.friction import sliding_friction
from hsr_pin.trajectory import Array


class StribeckFriction(JointCause):
    """Friction of the joints that falls from a higher level near standstill to a lower level with speed."""

    name = "stribeck_friction"
    kind = "friction"
    description = "friction of the joints that is higher near standstill than at speed"
    citation = "R. Stribeck, VDI-Zeitschrift 46 (1902); B. Armstrong-Helouvry et al., Automatica 30 (1994)"
    contains = ("coulomb_friction",)

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the sliding level and the increase at rest of each joint, and the speed over which the increase decays."""
        return (
            *(
                amplitude(joint_parameter("level", joint), 0.1 * scales.torque[k], "N m", lower=0.0)
                for k, joint in enumerate(joints)
            ),
            *(
                amplitude(joint_parameter("at_rest", joint), 0.1 * scales.torque[k], "N m", lower=0.0)
                for k, joint in enumerate(joints)
            ),
            shape("speed", 0.1, 0.02, 1.0, "rad/s"),
        )

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the regularised friction torque and its slope."""
        excess = values.of_joints("at_rest") * np.exp(-((now.v / values.shared("speed")) ** 2))
        return sliding_friction(values.of_joints("level") + excess, now.v)
