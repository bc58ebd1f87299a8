"""A torque that goes up and down with the angle of the joints, as of cogging."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values, of
from hsr_pin.trajectory import Array


class TorqueRipple(JointCause):
    """A torque that goes up and down with the angle of the joints, as of cogging."""

    name = "torque_ripple"
    kind = "actuation_map"
    description = "a torque that goes up and down with the angle of the joints, as of cogging"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """Cosine and sine of each joint, and how often per turn."""
        return (
            *(amplitude(of("cosine", joint), 0.05 * sizes.torque[k], "N m") for k, joint in enumerate(joints)),
            *(amplitude(of("sine", joint), 0.05 * sizes.torque[k], "N m") for k, joint in enumerate(joints)),
            shape("per_turn", 6.0, 1.0, 40.0),
        )

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """By the angle."""
        angle = values.shared("per_turn") * now.q
        return values.of_joints("cosine") * np.cos(angle) + values.of_joints("sine") * np.sin(angle), np.zeros_like(now.v)
