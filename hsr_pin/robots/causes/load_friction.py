"""Friction of the joints that grows with the torque that they transmit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.robots.friction import sliding
from hsr_pin.trajectory import Array


class LoadFriction(JointCause):
    """Friction of the joints that grows with the torque that they transmit."""

    name = "load_friction"
    kind = "friction"
    description = "friction of the joints that grows with the torque that they transmit"
    citation = "M. Duclusaud et al., Extended friction models for the physics simulation of servo actuators, arXiv 2410.08650"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A coefficient of each joint."""
        return tuple(amplitude(joint, 0.05, lower=0.0, upper=1.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Against the motion."""
        return sliding(values.of_joints() * np.abs(now.driven), now.v)
