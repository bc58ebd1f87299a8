"""A spring at the joints, as of a cable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values, of
from hsr_pin.trajectory import Array


class JointSpring(JointCause):
    """A spring at the joints, as of a cable."""

    name = "joint_spring"
    kind = "elastic"
    description = "a spring at the joints, as of a cable"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A stiffness of each joint, and the torque with which it pulls at the angle 0."""
        stiffness = 0.1 * sizes.torque / sizes.angle
        return (
            *(amplitude(of("stiffness", joint), stiffness[k], "N m/rad", lower=0.0) for k, joint in enumerate(joints)),
            *(amplitude(of("pull", joint), 0.1 * sizes.torque[k], "N m") for k, joint in enumerate(joints)),
        )

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Towards where it is relaxed."""
        return values.of_joints("pull") - values.of_joints("stiffness") * now.q, np.zeros_like(now.v)
