"""A constant torque in addition to the command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class TorqueBias(Effect):
    """Constant torque in addition to the command, also before the first step: y = u + bias."""

    name = "torque_bias"
    lacks = "a constant torque is added"
    cause = "pressure offset, unequal muscles"
    citation = "F. Daerden, D. Lefeber, Pneumatic artificial muscles, Eur. J. Mech. Environ. Eng. 47 (2002)"
    kind = "actuation_map"

    bias: float = parameter(
        0.0, lower=-1.0, upper=1.0, unit="Nm", scale=0.05, amplitude=True, level_exponent=1, description="additional torque"
    )

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        return torque + p.bias, memory
