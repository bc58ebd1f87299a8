"""Torques that follow the recorded ones slowly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class DriveLag(JointCause):
    """Torques that follow the recorded ones slowly."""

    name = "drive_lag"
    kind = "actuation_time"
    description = "torques that follow the recorded ones slowly"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A time constant of all joints."""
        return (amplitude("time_constant", 0.01, "s", lower=0.0, upper=0.5),)

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """First order, exact for torques that go straight from sample to sample."""
        lag = values.shared("time_constant")
        if not lag.any():
            return command
        late, step = command.copy(), np.diff(time)
        for n, dt in enumerate(step, 1):
            x = dt / np.maximum(lag, 1e-9)
            stays = np.exp(-x)
            mean = (1 - stays) / x  # of the weight over the step
            late[:, n] = stays * late[:, n - 1] + (mean - stays) * command[:, n - 1] + (1 - mean) * command[:, n]
        return late
