"""Cables that pull and do not push."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.parameters import amplitude

#: Index of the option ``pulls`` "positive".
POSITIVE = 0


@dataclass(frozen=True)
class OneSidedCable(Effect):
    """Cable that pulls to one side and becomes slack when it is released further: y = u while it pulls, (1 - lost) u otherwise.

    With ``lost`` = 1 only the arm's own stiffness moves it back; with less, another cable or a bias pulls with the rest. A slack
    that each cable of a pair has to take up before it pulls is the threshold of :class:`~hsr_pin.effects.torque_map.TorqueMap`.
    """

    name = "one_sided_cable"
    lacks = "a cable pulls and does not push"
    cause = "a single cable, or a slack one on the other side"
    citation = (
        "V. Agrawal, W. J. Peine, B. Yao, Modeling of transmission characteristics across a cable-conduit system, IEEE Trans. "
        "Robot. 26 (2010)"
    )
    kind = "actuation_map"
    in_space = False  # the side would need a direction

    lost: float = amplitude(0.2, "1", lower=0.0, upper=1.0, description="share of the torque that is lost on one side")
    pulls: str = option("positive", "negative", description="side to which the cable pulls")

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        pushed = np.minimum(torque, 0.0) if p.pulls == POSITIVE else np.maximum(torque, 0.0)
        return torque - p.lost * pushed, memory
