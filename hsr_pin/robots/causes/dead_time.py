"""Cause ``dead_time``: a constant delay of the commands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class DeadTime(JointCause):
    """Commands that act later than recorded, by a constant delay."""

    name = "dead_time"
    kind = "actuation_time"
    description = "commands that act later than recorded, by a constant delay"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the delay, common to all joints."""
        return (amplitude("delay", 0.01, "s", lower=-0.1, upper=0.3),)

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """Return the commands shifted by the delay."""
        return delayed(time, command, values.shared("delay")[:, 0])


def delayed(time: Array, command: Array, delays: Array) -> Array:
    """Return commands (B, N, n) at times (N,) [s], each simulation with its own delay (B,) [s]."""
    found = command.copy()
    for b in np.flatnonzero(delays):
        for k in range(command.shape[2]):
            found[b, :, k] = np.interp(time - delays[b], time, command[b, :, k])
    return found
