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
        """By what share of the largest recorded torque the limit of each joint is lower than it."""
        return tuple(amplitude(joint, 0.1, lower=0.0, upper=0.95) for joint in joints)

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array]:
        """Cut off."""
        share = values.of_joints()
        limit = np.where(share > 0, (1 - share) * values.sizes.largest, np.inf)
        return np.clip(torque, -limit, limit), (np.abs(torque) <= limit).astype(float)
