"""A torque that comes through two lags, late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class LagCascade(Effect):
    """T1 dy/dt = u - y, T2 dz/dt = y - z, ``delay`` late: a lag of second order.

    The second takes the mean of the first's step.
    """

    name = "lag_cascade"
    lacks = "the torque comes slowly and late"
    cause = "any linear delay of the supply"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"
    kind = "actuation_time"
    flexible = True
    memories = 2

    first: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, description="time constant")
    second: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, description="time constant")
    delay: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, description="of both")

    def late(self) -> Any:
        return self.delay

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        y = torque + (memory[0] - torque) * np.exp(-step / np.maximum(p.first, 1e-3 * step))
        mean = torque - p.first / step * (y - memory[0])
        z = mean + (memory[1] - mean) * np.exp(-step / np.maximum(p.second, 1e-3 * step))
        return mean - p.second / step * (z - memory[1]), (y, z)
