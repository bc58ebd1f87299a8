"""Lag of actuators that fill slowly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.parameters import amplitude

#: Indices of the option ``order``.
FIRST, SECOND = 0, 1


@dataclass(frozen=True)
class ActuatorLag(Effect):
    """Lag of the torque behind the command, of first or second order or as through an orifice: T dy/dt = u - y.

    Over a step h with constant u, y' = u + (y - u) exp(-h/T), and the mean of y is u - (T/h) (y' - y).

    The lag of second order, as of a chamber behind a tube, consists of two such lags with half of T; the second one gets the mean
    of the first over the step. Through an orifice the flow is proportional to the square root of the pressure difference (ISO
    6358): T dy/dt = sqrt(Keq |u - y|) towards u, which is reached after 2 T sqrt(|u - y| / Keq).
    """

    name = "actuator_lag"
    lacks = "the torque follows the command with a lag of first or second order, or as through an orifice"
    cause = "filling of the muscles, regulators"
    memories = 2
    citation = "G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998)"
    kind = "actuation_time"

    time_constant: float = amplitude(0.05, "s", lower=0.0, upper=5.0, level_exponent=1, description="time constant of the lag")
    order: str = option("first", "second", "orifice", description="order of the lag, or filling through an orifice")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        if p.order > SECOND:
            gap, time = memory[0] - torque, 2 * p.time_constant / np.sqrt(keq)
            root, way = np.sqrt(np.abs(gap)), gap / np.maximum(np.abs(gap), 1e-300)
            after = np.maximum(root - step / np.maximum(time, 1e-3 * step), 0.0)
            y = torque + way * after**2
            return torque + way * (root**3 - after**3) * time / (3 * step), (y, y)
        lag = p.time_constant if p.order == FIRST else p.time_constant / 2
        kept = np.exp(-step / np.maximum(lag, 1e-3 * step))  # 0 where there is no lag
        y = torque + (memory[0] - torque) * kept
        mean = torque - lag / step * (y - memory[0])
        if p.order == FIRST:
            return mean, (y, y)
        z = mean + (memory[1] - mean) * kept
        return mean - lag / step * (z - memory[1]), (y, z)
