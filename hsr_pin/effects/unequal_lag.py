"""Actuators that fill and empty with different time constants, after a delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.effects.vector import chosen
from hsr_pin.parameters import amplitude

#: Index of the option ``fills`` "either".
EITHER = 0


@dataclass(frozen=True)
class UnequalLag(Effect):
    """Lag with different time constants for rise and fall, after a delay: T dy/dt = u - y.

    T = rise while |y| increases and T = fall while it decreases; the update is exact for a constant u. If one actuator does most
    of the work under permanent pressure, it fills for every change of the torque towards its side: T = rise while y increases
    towards that side, whatever its sign.
    """

    name = "unequal_lag"
    lacks = "the torque rises and falls with different time constants, after a delay"
    cause = "filling through a valve, venting through another"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"
    kind = "actuation_time"
    memories = 1
    contains = ("actuator_lag", "dead_time")
    distinguished_by = ("rise", "fall")

    rise: float = amplitude(0.05, "s", lower=0.0, upper=5.0, description="time constant of filling")
    fall: float = amplitude(0.05, "s", lower=0.0, upper=10.0, description="time constant of venting")
    delay: float = amplitude(0.05, "s", lower=0.0, upper=5.0, description="delay before both")
    fills: str = option(
        "either", "positive", description="the actuator that fills: that of the bent side, or always that of one side"
    )

    @property
    def in_space(self) -> bool:
        return self.fills == "either"

    def command_delay(self) -> Any:
        return self.delay

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        filled, before = (np.abs(torque), np.abs(memory[0])) if p.fills == EITHER else (np.real(torque), np.real(memory[0]))
        lag = chosen(filled > before, p.rise, p.fall)
        y = torque + (memory[0] - torque) * np.exp(-step / np.maximum(lag, 1e-3 * step))
        return torque - lag / step * (y - memory[0]), (y,)
