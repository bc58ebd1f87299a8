"""Cause ``saturation``: a limit of the motor torques."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class Saturation(JointCause):
    """A limit of the motor torques."""

    name = "saturation"
    kind = "actuation_map"
    description = "a limit of the motor torques"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return by what share the limit of each joint is below its largest recorded torque."""
        return tuple(amplitude(joint, 0.1, lower=0.0, upper=0.95) for joint in joints)

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array]:
        """Return the torque clipped to the limit, and its derivative."""
        share = values.of_joints()
        limit = np.where(share > 0, (1 - share) * values.scales.max_torque, np.inf)
        return np.clip(torque, -limit, limit), (np.abs(torque) <= limit).astype(float)
