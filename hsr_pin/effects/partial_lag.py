"""A torque of which a share arrives at once, and the rest with a lag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude, shape


@dataclass(frozen=True)
class PartialLag(Effect):
    """Lead and lag of the torque: y = at_once u + (1 - at_once) x, T dx/dt = u - x.

    The transfer function is (1 + at_once T s) / (1 + T s); the update is exact for a constant u.
    """

    name = "partial_lag"
    lacks = "a share of the torque arrives at once, the rest with a lag"
    cause = "a command that was filtered before it was logged, a second volume behind a muscle"
    citation = "G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998)"
    kind = "actuation_time"
    memories = 1
    contains = ("actuator_lag",)

    time_constant: float = amplitude(0.05, "s", lower=0.0, upper=5.0, description="time constant of the lagging share")
    at_once: float = shape(0.3, 0.1, "1", lower=0.0, upper=0.95, description="share that arrives at once")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        x = torque + (memory[0] - torque) * np.exp(-step / np.maximum(p.time_constant, 1e-3 * step))
        return torque - (1 - p.at_once) * p.time_constant / step * (x - memory[0]), (x,)
