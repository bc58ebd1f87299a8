"""Play between the motors and their joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import Sizes, Values
from hsr_pin.robots.transmission import Motor, Transmission
from hsr_pin.trajectory import Array

#: How a motor rings against the flank of a tooth [rad/s], and its damping ratio.
_RINGS, _DAMPED = 250.0, 0.3
#: How sure it is that a joint begins at the flank that is pushed, for the usual torque.
_SURE = 5.0


class Backlash(Transmission):
    """Play between the motors and their joints."""

    name = "backlash"
    kind = "transmission"
    description = "play between the motors and their joints"
    citation = "M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002)"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """How far each joint turns freely."""
        return (*(amplitude(joint, 0.01, "rad", lower=0.0, upper=0.3) for joint in joints), *self.shared(sizes))

    def there(self, values: Values) -> NDArray[np.bool_]:
        """Where there is a gap."""
        return values.of_joints() > 0

    def passed(self, values: Values, motor: Motor, h: Array) -> tuple[Array, Array]:
        """A stiff flank on either side of the gap, as it is at the end of the step; it pushes and never pulls."""
        inertia, half = self.inertia(values), values.of_joints() / 2
        stiffness, damping = inertia * _RINGS**2, 2 * _DAMPED * inertia * _RINGS
        end = motor.ahead + h * motor.faster
        torque = stiffness * (end - np.clip(end, -half, half)) + damping * motor.faster
        touches = (np.abs(end) > half) & (torque * end > 0)
        return np.where(touches, torque, 0.0), np.where(touches, stiffness * h / 2 + damping, 0.0)

    def apart(self, values: Values, torque: Array) -> Array:
        """At the flank that the torque pushes, or near it."""
        pushed = np.tanh(_SURE * torque / values.sizes.torque)
        return pushed * values.of_joints() / 2 + torque / (self.inertia(values) * _RINGS**2)
