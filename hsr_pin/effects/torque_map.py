"""A torque that is not linear in the commanded bending."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude

#: Index of the parity "odd".
ODD = 0


@dataclass(frozen=True)
class TorqueMap(Effect):
    """Nonlinear map from command to torque: y = x + quadratic x w / Keq, x = u - clip(u, -threshold Keq, threshold Keq).

    u / Keq is the commanded bending; the map also holds before the first step. Below the threshold nothing moves, because a
    bladder first fills its braid. ``parity`` defines the map for negative torques: "odd", w = |x|, the same on both sides;
    "even", w = x, a parabola.
    """

    name = "torque_map"
    lacks = "torque is not linear in the commanded bending"
    cause = "the fit of Eqs. (1) and (4)"
    citation = "C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE TRA 12 (1996)"
    kind = "actuation_map"
    alternative_amplitudes = ("quadratic", "threshold")

    quadratic: float = amplitude(
        0.1, "1/rad", lower=-0.6, upper=1.0, description="relative increase of the torque per commanded bending"
    )
    threshold: float = amplitude(
        0.05, "rad", lower=0.0, upper=1.0, level_exponent=-1, description="commanded bending up to which no torque arrives"
    )
    parity: str = option("odd", "even", description="parity of the quadratic term")

    @property
    def in_space(self) -> bool:
        return self.parity == "odd"  # a parabola would need a direction in space

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        passed = torque - limited(torque, p.threshold * keq)
        weight = np.abs(passed) if p.parity == ODD else passed
        return passed + p.quadratic * passed * weight / keq, memory
