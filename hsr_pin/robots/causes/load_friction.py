"""Cause ``load_friction``: friction of the joints in proportion to the torque of their motors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.robots.friction import sliding_friction
from hsr_pin.trajectory import Array


class LoadFriction(JointCause):
    """Friction of the joints in proportion to the torque of their motors."""

    name = "load_friction"
    kind = "friction"
    description = "friction of the joints in proportion to the torque of their motors"
    citation = "M. Duclusaud et al., Extended friction models for the physics simulation of servo actuators, arXiv 2410.08650"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the friction coefficient of each joint."""
        return tuple(amplitude(joint, 0.05, lower=0.0, upper=1.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the regularised friction torque and its slope."""
        return sliding_friction(values.of_joints() * np.abs(now.motor_torque), now.v)
