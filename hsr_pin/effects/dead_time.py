"""A torque that comes late."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.effects.effect import Command, Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class DeadTime(Effect):
    """y(t) = u(t - delay).

    With u held over each step h and delay = (k + f) h, the mean of y over step n is (1 - f) u[n - k] + f u[n - k - 1]: the delay
    is resolved within a step, and the motion changes evenly with it.
    """

    name = "dead_time"
    lacks = "the torque follows the command late"
    cause = "valves, sampling, clock offset"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"

    delay: float = parameter(0.0, lower=0.0, upper=0.5, unit="s", scale=0.02, amplitude=True, description="of the torque")

    def command(self, command: Command) -> Command:
        steps, count = command.torque.shape
        held = np.concatenate([command.initial[None], command.torque])  # held[n + 1] is the torque of step n
        late = np.broadcast_to(np.asarray(self.delay) / command.step, count)
        whole = np.floor(late)
        part = late - whole
        index = np.arange(1, steps + 1)[:, None] - whole.astype(int)
        column = np.arange(count)
        newer, older = held[np.maximum(index, 0), column], held[np.maximum(index - 1, 0), column]
        return replace(command, torque=(1 - part) * newer + part * older)
