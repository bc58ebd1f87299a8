"""Cause ``torque_bias``: a constant unrecorded torque at the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class TorqueBias(JointCause):
    """A constant unrecorded torque at the joints."""

    name = "torque_bias"
    kind = "actuation_map"
    description = "a constant unrecorded torque at the joints"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the torque of each joint."""
        return tuple(amplitude(joint, 0.05 * scales.torque[k], "N m") for k, joint in enumerate(joints))

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array]:
        """Return the torque plus the bias, and the derivative 1."""
        return torque + values.of_joints(), np.ones_like(torque)
