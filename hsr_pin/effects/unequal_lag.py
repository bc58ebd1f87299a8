"""Muscles that fill and empty at different speeds, and start late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.effects.vector import chosen
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class UnequalLag(Effect):
    """T dy/dt = u - y, T = rise while |y| grows and fall while it shrinks; y comes ``delay`` late. Exact for a held u."""

    name = "unequal_lag"
    lacks = "the torque rises and falls with different time constants, late"
    cause = "filling through a valve, venting through another"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"
    kind = "actuation_time"
    memories = 1
    contains = ("actuator_lag", "dead_time")

    rise: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, description="time constant, filling")
    fall: float = parameter(
        0.0, lower=0.0, upper=10.0, unit="s", scale=0.05, amplitude=True, description="time constant, venting"
    )
    delay: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.05, amplitude=True, description="of both")

    def late(self) -> Any:
        return self.delay

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        lag = chosen(np.abs(torque) > np.abs(memory[0]), p.rise, p.fall)
        y = torque + (memory[0] - torque) * np.exp(-step / np.maximum(lag, 1e-3 * step))
        return torque - lag / step * (y - memory[0]), (y,)
