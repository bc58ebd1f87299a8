"""Friction of cables along the way on which they are wrapped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.effects.vector import chosen
from hsr_pin.parameters import amplitude

#: Signs of the exponent while a cable is pulled and while it is released.
PULLED, RELEASED = -1.0, 1.0
#: Exponent below which the mean along the arm is a series.
_STRAIGHT = 1e-6


def arriving(torque: Any, conduit: Any, friction: Any, keq: Any, way: float) -> Any:
    """Return the mean torque along the arm [N m] while the cable is pulled (way -1) or released (way 1)."""
    wrapped = friction * np.abs(torque) / keq
    mean = chosen(wrapped > _STRAIGHT, way * np.expm1(way * wrapped) / np.maximum(wrapped, _STRAIGHT), 1.0 + way * wrapped / 2)
    return torque * np.exp(way * conduit) * mean


@dataclass(frozen=True)
class CapstanFriction(Effect):
    """Friction of a cable that grows exponentially with the angle along which it is wrapped.

    After a wrapped angle with the exponent a (angle times coefficient of friction), a tension T is T exp(-a) while the cable is
    pulled, and T exp(a) while it is released; in between nothing moves, and the torque at the arm stays. ``conduit`` is the
    exponent of a conduit before the arm, which keeps its shape. Along the arm the exponent at arc length s is friction s |u| /
    Keq, because the arm is bent by u / Keq where gravity is small; the arm gets the mean over s.
    """

    name = "capstan_friction"
    lacks = "cables rub along their way, and more so the farther they are wrapped"
    cause = "cables in conduits, and through the eyes of a bent arm"
    citation = (
        "M. Kaneko, T. Yamashita, K. Tanie, Basic considerations on transmission characteristics for tendon drive robots, Proc. "
        "5th Int. Conf. Advanced Robotics (1991)"
    )
    kind = "friction"
    in_space = False  # the cables that share a torque about two axes are not known
    memories = 2
    alternative_amplitudes = ("friction", "conduit")

    friction: float = amplitude(0.1, "1/rad", lower=0.0, upper=1.5, description="coefficient of friction along the arm")
    conduit: float = amplitude(
        0.1, "1", lower=0.0, upper=1.5, description="coefficient of friction times wrapped angle of a conduit before the arm"
    )

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        # memory: the torque at the arm plus an offset, and the initial torque, to which the arm was pulled
        pulled = arriving(memory[1], p.conduit, p.friction, keq, PULLED)
        one = arriving(torque, p.conduit, p.friction, keq, PULLED)
        other = arriving(torque, p.conduit, p.friction, keq, RELEASED)
        before = memory[0] - memory[1] + pulled
        y = np.minimum(np.maximum(before, np.minimum(one, other)), np.maximum(one, other))
        return y, (y + memory[1] - pulled, memory[1])
