"""Torque over command, as a curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import parameter


@dataclass(frozen=True)
class TorqueCurve(Effect):
    """y = u exp(even x + odd (|x| - 1) + cubic (x^2 - 1)), x = u / Keq; the exponent stays between -5 and 5."""

    name = "torque_curve"
    lacks = "the torque is another function of the command"
    cause = "any map from pressure to torque that has no memory"
    citation = "C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE TRA 12 (1996)"
    kind = "actuation_map"
    flexible = True

    even: float = parameter(
        0.0, lower=-8.0, upper=8.0, unit="1/rad", scale=0.1, amplitude=True, description="parabola in the command"
    )
    odd: float = parameter(
        0.0, lower=-8.0, upper=8.0, unit="1/rad", scale=0.1, amplitude=True, description="the same to both sides"
    )
    cubic: float = parameter(0.0, lower=-8.0, upper=8.0, unit="1/rad^2", scale=0.1, amplitude=True, description="with its square")

    @property
    def in_space(self) -> bool:
        return False

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        x = torque / keq
        exponent = p.even * x + p.odd * (np.abs(x) - 1.0) + p.cubic * (x * x - 1.0)
        return torque * np.exp(np.minimum(np.maximum(exponent, -5.0), 5.0)), memory
