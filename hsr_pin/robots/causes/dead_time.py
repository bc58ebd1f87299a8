"""Torques that act later than recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class DeadTime(JointCause):
    """Torques that act later than recorded."""

    name = "dead_time"
    kind = "actuation_time"
    description = "torques that act later than recorded"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A delay of all joints."""
        return (amplitude("delay", 0.01, "s", lower=-0.1, upper=0.3),)

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """The same, later."""
        delayed = command.copy()
        for b, delay in enumerate(values.shared("delay")[:, 0]):
            if delay:
                for k in range(command.shape[2]):
                    delayed[b, :, k] = np.interp(time - delay, time, command[b, :, k])
        return delayed
