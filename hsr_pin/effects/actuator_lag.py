"""Muscles that fill slowly."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.effects.effect import Command, Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class ActuatorLag(Effect):
    """T dy/dt = u - y. Over a step h with u held: y' = u + (y - u) exp(-h/T), and the mean of y is u - (T/h) (y' - y)."""

    name = "actuator_lag"
    lacks = "the torque follows the command as a first-order lag"
    cause = "filling of the muscles, regulators"
    citation = "G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998)"

    time_constant: float = parameter(0.0, lower=0.0, upper=1.0, unit="s", scale=0.05, amplitude=True, description="of the lag")

    def command(self, command: Command) -> Command:
        lag = np.asarray(self.time_constant)
        kept = np.exp(-command.step / np.maximum(lag, 1e-3 * command.step))  # 0 where there is no lag
        mean = np.empty_like(command.torque)
        y = command.initial
        for n, u in enumerate(command.torque):
            y_next = u + (y - u) * kept
            mean[n] = u - lag / command.step * (y_next - y)
            y = y_next
        return replace(command, torque=mean)
