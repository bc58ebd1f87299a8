"""Torques that do not exceed a limit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class Saturation(JointCause):
    """Torques that do not exceed a limit."""

    name = "saturation"
    kind = "actuation_map"
    description = "torques that do not exceed a limit"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """By how much of the largest usual torque the limit is lower, of each joint."""
        return tuple(amplitude(joint, 0.1, lower=0.0, upper=0.95) for k, joint in enumerate(joints))

    def command(self, values: Values, time: Array, torque: Array) -> Array:
        """Cut off: at 0 there is no limit."""
        largest = np.abs(torque).max(axis=1, keepdims=True)
        limit = (1 - values.of_joints()[:, None]) * largest
        return np.clip(torque, -limit, limit)
