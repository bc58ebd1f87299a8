"""Cause ``backlash``: play between the motors and their joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import Scales, Values
from hsr_pin.robots.transmission import Motor, Transmission
from hsr_pin.trajectory import Array

#: Natural frequency [rad/s] and damping ratio of a motor against the flank of a tooth.
_FREQUENCY, _DAMPING_RATIO = 250.0, 0.3
#: Sharpness of the transition between the flanks at the start, at the RMS torque of the joint.
_SHARPNESS = 5.0


class Backlash(Transmission):
    """Play between the motors and their joints."""

    name = "backlash"
    kind = "transmission"
    description = "play between the motors and their joints"
    citation = "M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002)"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the width of the play of each joint."""
        return (*(amplitude(joint, 0.01, "rad", lower=0.0, upper=0.3) for joint in joints), *self.shared(scales))

    def is_present(self, values: Values) -> NDArray[np.bool_]:
        """Return where the play is larger than 0."""
        return values.of_joints() > 0

    def transmitted(self, values: Values, motor: Motor, h: Array) -> tuple[Array, Array]:
        """Return the torque of the stiff, damped flanks of the gap at the end of the step; a flank pushes and never pulls."""
        inertia, half = self.inertia(values), values.of_joints() / 2
        stiffness, damping = inertia * _FREQUENCY**2, 2 * _DAMPING_RATIO * inertia * _FREQUENCY
        end = motor.lead + h * motor.lead_rate
        torque = stiffness * (end - np.clip(end, -half, half)) + damping * motor.lead_rate
        touches = (np.abs(end) > half) & (torque * end > 0)
        return np.where(touches, torque, 0.0), np.where(touches, stiffness * h / 2 + damping, 0.0)

    def static_lead(self, values: Values, torque: Array) -> Array:
        """Return the lead at which the motor touches the flank that its torque pushes, smoothed around zero torque."""
        pushed = np.tanh(_SHARPNESS * torque / values.scales.torque)
        return pushed * values.of_joints() / 2 + torque / (self.inertia(values) * _FREQUENCY**2)
