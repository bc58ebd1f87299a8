"""A torque that comes late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class DeadTime(Effect):
    """y(t) = u(t - delay), the delay resolved within a step: the motion changes evenly with it."""

    name = "dead_time"
    lacks = "the torque follows the command late"
    cause = "valves, sampling, clock offset"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"
    kind = "actuation_time"

    delay: float = parameter(0.0, lower=0.0, upper=5.0, unit="s", scale=0.02, amplitude=True, description="of the torque")

    def late(self) -> Any:
        return self.delay
