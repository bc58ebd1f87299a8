"""Actuators in space with rotated axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class TurnedActuation(Effect):
    """Rotation of the actuation axes about the straight arm, from x towards y: y = u exp(i angle)."""

    name = "turned_actuation"
    lacks = "the axes of actuation are rotated"
    cause = "chambers or tendons that are rotated or twisted about the arm, wrongly declared axes of the base"
    citation = (
        "R. J. Webster III, B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, IJRR 29 (2010)"
    )
    kind = "actuation_map"
    in_plane = False

    angle: float = amplitude(0.05, "rad", lower=-1.6, upper=1.6, description="rotation from x towards y of the base")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        return torque * (np.cos(p.angle) + 1j * np.sin(p.angle)), memory
