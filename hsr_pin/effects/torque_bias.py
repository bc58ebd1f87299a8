"""A constant torque in addition to the command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class TorqueBias(Effect):
    """Constant torque in addition to the command, also before the first step: y = u + bias."""

    name = "torque_bias"
    lacks = "a constant torque is added"
    cause = "pressure offset, unequal muscles"
    citation = "F. Daerden, D. Lefeber, Pneumatic artificial muscles, Eur. J. Mech. Environ. Eng. 47 (2002)"
    kind = "actuation_map"

    bias: float = amplitude(0.05, "Nm", lower=-1.0, upper=1.0, level_exponent=1, description="additional torque")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        return torque + p.bias, memory
