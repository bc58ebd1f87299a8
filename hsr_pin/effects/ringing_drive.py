"""A drive that oscillates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude, shape


@dataclass(frozen=True)
class RingingDrive(Effect):
    """Drive that oscillates about the command: y'' + 2 zeta w y' + w^2 y = w^2 u, w = 2 pi / period.

    This describes a motor with inertia behind a servo; the update is exact for a constant u. With a damping ratio of 1 it is a
    lag of second order; with less, the torque overshoots.
    """

    name = "ringing_drive"
    lacks = "the torque oscillates about the command before it settles"
    cause = "a motor with inertia behind its servo, a regulator with too high a gain"
    citation = "G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998)"
    kind = "actuation_time"
    memories = 3

    period: float = amplitude(0.1, "s", lower=0.0, upper=5.0, description="period of the free oscillation")
    damping_ratio: float = shape(0.3, 0.2, "1", lower=0.02, upper=0.98, description="damping ratio of the drive")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        swing = 2 * np.pi / np.maximum(p.period, 1e-3 * step)
        decay, turn = p.damping_ratio * swing, swing * np.sqrt(1 - p.damping_ratio**2)
        # memory: the torque, its rate plus an offset, and this offset (the initial torque), so that the drive starts at rest
        gap, rate = memory[0] - torque, memory[1] - memory[2]
        kept, c, s = np.exp(-decay * step), np.cos(turn * step), np.sin(turn * step)
        side = (rate + decay * gap) / turn
        after = kept * (gap * c + side * s)
        speed = kept * ((side * turn - decay * gap) * c - (gap * turn + decay * side) * s)
        time = p.period / (2 * np.pi)
        area = 2 * p.damping_ratio * time * (gap - after) + time**2 * (rate - speed)  # the equation of motion, integrated
        return torque + area / step, (torque + after, speed + memory[2], memory[2])
