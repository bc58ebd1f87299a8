"""A spring at the joints, as of a cable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values, of
from hsr_pin.trajectory import Array


class JointSpring(JointCause):
    """A spring at the joints, as of a cable."""

    name = "joint_spring"
    kind = "elastic"
    description = "a spring at the joints, as of a cable"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A stiffness and a constant torque of each joint: where it is relaxed."""
        stiffness = [0.1 * torque / angle for torque, angle in zip(sizes.torque, sizes.angle, strict=True)]
        return (
            *(amplitude(of("stiffness", joint), stiffness[k], "N m/rad", lower=0.0) for k, joint in enumerate(joints)),
            *(shape(of("relaxed", joint), 0.0, -2 * a, 2 * a, "rad") for joint, a in zip(joints, sizes.angle, strict=True)),
        )

    def torque(self, values: Values, q: Array, v: Array, driven: Array) -> tuple[Array, Array]:
        """Towards where it is relaxed."""
        return -values.of_joints("stiffness") * (q - values.of_joints("relaxed")), np.zeros_like(v)
