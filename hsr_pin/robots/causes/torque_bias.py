"""A constant torque at the joints that is not recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class TorqueBias(JointCause):
    """A constant torque at the joints that is not recorded."""

    name = "torque_bias"
    kind = "actuation_map"
    description = "a constant torque at the joints that is not recorded"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A torque of each joint."""
        return tuple(amplitude(joint, 0.05 * sizes.torque[k], "N m") for k, joint in enumerate(joints))

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array]:
        """Added."""
        return torque + values.of_joints(), np.ones_like(torque)
