"""A constant torque beside the command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class TorqueBias(Effect):
    """y = u + bias, also before the first step."""

    name = "torque_bias"
    lacks = "a constant torque is added"
    cause = "pressure offset, unequal muscles"
    citation = "F. Daerden, D. Lefeber, Pneumatic artificial muscles, Eur. J. Mech. Environ. Eng. 47 (2002)"

    bias: float = parameter(0.0, lower=-1.0, upper=1.0, unit="Nm", scale=0.05, amplitude=True, description="torque added")

    def command(self, torque: Array, past: Any, step: float, keq: Array) -> tuple[Array, Any]:
        return torque + self.bias, None
