"""A constant additional torque in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class TorqueOffset(Effect):
    """Constant torque in addition to the command, also before the first step: y = u + offset.

    This is the spatial version of :class:`~hsr_pin.effects.torque_bias.TorqueBias`.
    """

    name = "torque_offset"
    lacks = "a constant torque towards one side is added"
    cause = "pressure offset, unequal muscles"
    citation = "F. Daerden, D. Lefeber, Pneumatic artificial muscles, Eur. J. Mech. Environ. Eng. 47 (2002)"
    kind = "actuation_map"
    in_plane = False
    contains = ("torque_bias",)

    towards_x: float = amplitude(0.05, "Nm", lower=-1.0, upper=1.0, level_exponent=1, description="additional torque towards x")
    towards_y: float = amplitude(0.05, "Nm", lower=-1.0, upper=1.0, level_exponent=1, description="additional torque towards y")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        return torque + (p.towards_x + 1j * p.towards_y), memory
