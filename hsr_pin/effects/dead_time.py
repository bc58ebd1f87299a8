"""A torque that comes late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class DeadTime(Effect):
    """y(t) = u(t - delay).

    With u held over each step h and delay = (k + f) h, the mean of y over step n is (1 - f) u[n - k] + f u[n - k - 1]: the delay
    is resolved within a step, and the motion changes evenly with it. Steps may differ in length: what is remembered are the held
    torques of the last ``delay`` seconds and how long each was held, the oldest for ever.
    """

    name = "dead_time"
    lacks = "the torque follows the command late"
    cause = "valves, sampling, clock offset"
    citation = "E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system: Part I, J. Dyn. Syst. 122 (2000)"

    delay: float = parameter(0.0, lower=0.0, upper=0.5, unit="s", scale=0.02, amplitude=True, description="of the torque")

    def command(self, torque: Array, past: Any, step: float, keq: Array) -> tuple[Array, Any]:
        if past is None:
            return torque, (np.array([np.inf]), torque[None])
        lengths, torques = np.append(step, past[0]), np.concatenate([torque[None], past[1]])  # (K,) [s], (K, B), newest first
        ages = np.append(0.0, lengths.cumsum())[:, None]  # of their ends, when this step ends
        delay = np.asarray(self.delay)
        heard = np.maximum(np.minimum(ages[1:], delay + step) - np.maximum(ages[:-1], delay), 0.0)  # [s] in this step
        needed = max(1, int(np.count_nonzero(ages[:-1] < delay.max())))
        lengths = np.append(lengths[: needed - 1], np.inf)
        return (heard / heard.sum(axis=0) * torques).sum(axis=0), (lengths, torques[:needed])
