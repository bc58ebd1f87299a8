"""A torque with two lags and a delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class LagCascade(Effect):
    """Lag of second order with a delay: T1 dy/dt = u - y, T2 dz/dt = y - z, where u is the delayed command.

    The second lag gets the mean of the first over the step.
    """

    name = "lag_cascade"
    lacks = "the torque arrives slowly and with a delay"
    cause = "any linear delay of the supply"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"
    kind = "actuation_time"
    flexible = True
    memories = 2

    first: float = amplitude(0.05, "s", lower=0.0, upper=5.0, description="time constant of the first lag")
    second: float = amplitude(0.05, "s", lower=0.0, upper=5.0, description="time constant of the second lag")
    delay: float = amplitude(0.05, "s", lower=0.0, upper=5.0, description="delay before both lags")

    def command_delay(self) -> Any:
        return self.delay

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        y = torque + (memory[0] - torque) * np.exp(-step / np.maximum(p.first, 1e-3 * step))
        mean = torque - p.first / step * (y - memory[0])
        z = mean + (memory[1] - mean) * np.exp(-step / np.maximum(p.second, 1e-3 * step))
        return mean - p.second / step * (z - memory[1]), (y, z)
