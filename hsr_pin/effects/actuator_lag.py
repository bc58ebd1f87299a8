"""Muscles that fill slowly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class ActuatorLag(Effect):
    """T dy/dt = u - y. Over a step h with u held: y' = u + (y - u) exp(-h/T), and the mean of y is u - (T/h) (y' - y)."""

    name = "actuator_lag"
    lacks = "the torque follows the command as a first-order lag"
    cause = "filling of the muscles, regulators"
    memories = 1
    citation = "G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998)"
    kind = "actuation_time"

    time_constant: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, description="of the lag")

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        kept = np.exp(-step / np.maximum(p.time_constant, 1e-3 * step))  # 0 where there is no lag
        y = torque + (memory[0] - torque) * kept
        return torque - p.time_constant / step * (y - memory[0]), (y,)
