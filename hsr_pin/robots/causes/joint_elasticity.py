"""Springs between the motors and their joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import Sizes, Values
from hsr_pin.robots.transmission import Motor, Transmission
from hsr_pin.trajectory import Array

#: Compliance of practical size: angle [rad] under the usual torque.
_ANGLE = 0.02


class JointElasticity(Transmission):
    """Springs between the motors and their joints."""

    name = "joint_elasticity"
    kind = "transmission"
    description = "springs between the motors and their joints"
    citation = "M. W. Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109 (1987)"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A compliance of each joint; the damping ratio of motor against link."""
        own = (amplitude(joint, _ANGLE / sizes.torque[k], "rad/(N m)", lower=0.0) for k, joint in enumerate(joints))
        return (*own, shape("damping_ratio", 0.1, 0.005, 1.0, start_count=1), *self.shared(sizes))

    def there(self, values: Values) -> NDArray[np.bool_]:
        """Where it has a compliance."""
        return values.of_joints() > 0

    def passed(self, values: Values, motor: Motor, h: Array) -> tuple[Array, Array]:
        """Spring and damper, their mean over the step."""
        stiffness = 1 / np.maximum(values.of_joints(), 1e-9)
        damping = 2 * values.shared("damping_ratio") * np.sqrt(stiffness * self.inertia(values))
        torque = stiffness * (motor.ahead + h / 2 * motor.faster) + damping * motor.faster
        return torque, stiffness * h / 4 + damping / 2

    def apart(self, values: Values, torque: Array) -> Array:
        """Drawn by the torque."""
        return values.of_joints() * torque
