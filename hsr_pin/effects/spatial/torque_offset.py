"""A constant additional torque in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter


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
    contains = ("torque_bias",)

    towards_x: float = parameter(
        0.0,
        lower=-1.0,
        upper=1.0,
        unit="Nm",
        scale=0.05,
        amplitude=True,
        level_exponent=1,
        description="additional torque towards x",
    )
    towards_y: float = parameter(
        0.0,
        lower=-1.0,
        upper=1.0,
        unit="Nm",
        scale=0.05,
        amplitude=True,
        level_exponent=1,
        description="additional torque towards y",
    )

    @property
    def in_plane(self) -> bool:
        return False

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        return torque + (p.towards_x + 1j * p.towards_y), memory
