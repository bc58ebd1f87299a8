"""Cause ``joint_elasticity``: springs between the motors and their joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import Scales, Values
from hsr_pin.robots.transmission import Motor, Transmission
from hsr_pin.trajectory import Array

#: Deflection under the RMS torque at a compliance of practical size [rad].
_DEFLECTION = 0.02


class JointElasticity(Transmission):
    """Springs between the motors and their joints."""

    name = "joint_elasticity"
    kind = "transmission"
    description = "springs between the motors and their joints"
    citation = "M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987)"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the compliance of each joint, and the damping ratio of motor against link."""
        own = (amplitude(joint, _DEFLECTION / scales.torque[k], "rad/(N m)", lower=0.0) for k, joint in enumerate(joints))
        return (*own, shape("damping_ratio", 0.1, 0.005, 1.0, start_count=1), *self.shared(scales))

    def is_present(self, values: Values) -> NDArray[np.bool_]:
        """Return where the compliance is larger than 0."""
        return values.of_joints() > 0

    def transmitted(self, values: Values, motor: Motor, h: Array) -> tuple[Array, Array]:
        """Return the torque of spring and damper, averaged over the step."""
        stiffness = 1 / np.maximum(values.of_joints(), 1e-9)
        damping = 2 * values.shared("damping_ratio") * np.sqrt(stiffness * self.inertia(values))
        torque = stiffness * (motor.lead + h / 2 * motor.lead_rate) + damping * motor.lead_rate
        return torque, stiffness * h / 4 + damping / 2

    def static_lead(self, values: Values, torque: Array) -> Array:
        """Return the deflection of the springs under the torque."""
        return values.of_joints() * torque
