"""Soft ends of the way of the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values, of
from hsr_pin.trajectory import Array

#: Angle [rad] over which a stop of practical size takes up the usual torque.
_SOFT = 0.1


class JointStop(JointCause):
    """Soft ends of the way of the joints."""

    name = "joint_stop"
    kind = "contact"
    description = "soft ends of the way of the joints"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A stiffness at the upper and at the lower end of each joint, and how far before the last angle seen the ends begin."""
        stiffness = sizes.torque / _SOFT
        return (
            *(amplitude(of("upper", joint), stiffness[k], "N m/rad", lower=0.0) for k, joint in enumerate(joints)),
            *(amplitude(of("lower", joint), stiffness[k], "N m/rad", lower=0.0) for k, joint in enumerate(joints)),
            shape("before", 0.05, 0.005, 0.5, "rad"),
        )

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Back from the ends."""
        above = np.maximum(now.q - (values.sizes.highest - values.shared("before")), 0.0)
        below = np.maximum(values.sizes.lowest + values.shared("before") - now.q, 0.0)
        return values.of_joints("lower") * below - values.of_joints("upper") * above, np.zeros_like(now.v)
