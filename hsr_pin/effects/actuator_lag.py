"""Muscles that fill slowly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.parameters import parameter

#: In the order of the option.
FIRST = 0


@dataclass(frozen=True)
class ActuatorLag(Effect):
    """T dy/dt = u - y. Over a step h with u held: y' = u + (y - u) exp(-h/T), and the mean of y is u - (T/h) (y' - y).

    Of second order, as of a chamber behind a tube: two of them with half of T, the second of which takes the mean of the first's
    step.
    """

    name = "actuator_lag"
    lacks = "the torque follows the command as a lag of first or second order"
    cause = "filling of the muscles, regulators"
    memories = 2
    citation = "G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998)"
    kind = "actuation_time"

    time_constant: float = parameter(
        0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, resizes=1, description="of the lag"
    )
    order: str = option("first", "second", description="of the lag")

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        lag = p.time_constant if p.order == FIRST else p.time_constant / 2
        kept = np.exp(-step / np.maximum(lag, 1e-3 * step))  # 0 where there is no lag
        y = torque + (memory[0] - torque) * kept
        mean = torque - lag / step * (y - memory[0])
        if p.order == FIRST:
            return mean, (y, y)
        z = mean + (memory[1] - mean) * kept
        return mean - lag / step * (z - memory[1]), (y, z)
