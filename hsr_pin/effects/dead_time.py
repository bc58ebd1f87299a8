"""A delay of the torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class DeadTime(Effect):
    """Delay of the torque behind the command: y(t) = u(t - delay).

    The delay is resolved within a step, so that the motion is a smooth function of it.
    """

    name = "dead_time"
    lacks = "the torque follows the command with a delay"
    cause = "valves, sampling, clock offset"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"
    kind = "actuation_time"

    delay: float = amplitude(0.02, "s", lower=0.0, upper=5.0, description="delay of the torque")

    def command_delay(self) -> Any:
        return self.delay
