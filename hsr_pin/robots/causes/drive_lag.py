"""Cause ``drive_lag``: first-order lag of the commands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class DriveLag(JointCause):
    """Commands that act with a first-order lag."""

    name = "drive_lag"
    kind = "actuation_time"
    description = "commands that act with a first-order lag"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the time constant, common to all joints."""
        return (amplitude("time_constant", 0.01, "s", lower=0.0, upper=0.5),)

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """Return the commands after a first-order lag, exact for linear interpolation between samples."""
        lag = values.shared("time_constant")
        if not lag.any():
            return command
        lagged, step = command.copy(), np.diff(time)
        for n, dt in enumerate(step, 1):
            x = dt / np.maximum(lag, 1e-9)
            stays = np.exp(-x)
            mean = (1 - stays) / x  # mean weight over the step
            lagged[:, n] = stays * lagged[:, n - 1] + (mean - stays) * command[:, n - 1] + (1 - mean) * command[:, n]
        return lagged
