"""A torque that is not linear in the commanded bending."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import parameter

#: Index of the first parity.
ODD = 0


@dataclass(frozen=True)
class TorqueMap(Effect):
    """y = x + quadratic x w / Keq, x = u - clip(u, -threshold Keq, threshold Keq), also before the first step.

    u / Keq is the commanded bending. Up to a threshold nothing moves: a bladder first fills its braid. ``parity`` says what
    becomes of torques below zero: "odd", w = |x|, and the arm bends to both sides alike; or "even", w = x, a parabola.
    """

    name = "torque_map"
    lacks = "torque is not linear in the commanded bending"
    cause = "the fit of Eqs. (1) and (4)"
    citation = "C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE TRA 12 (1996)"
    kind = "actuation_map"
    apart = ("quadratic", "threshold")

    quadratic: float = parameter(
        0.0,
        lower=-0.6,
        upper=1.0,
        unit="1/rad",
        scale=0.1,
        amplitude=True,
        description="relative gain of torque per commanded bending",
    )
    threshold: float = parameter(
        0.0,
        lower=0.0,
        upper=1.0,
        unit="rad",
        scale=0.05,
        amplitude=True,
        resizes=-1,
        description="commanded bending up to which no torque arrives",
    )
    parity: str = option("odd", "even", description="of the quadratic term")

    @property
    def in_space(self) -> bool:
        return self.parity == "odd"  # a parabola in a command of two components has a direction of its own

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        passed = torque - limited(torque, p.threshold * keq)
        weight = np.abs(passed) if p.parity == ODD else passed
        return passed + p.quadratic * passed * weight / keq, memory
