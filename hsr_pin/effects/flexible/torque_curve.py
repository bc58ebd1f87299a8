"""The torque as a curve over the command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class TorqueCurve(Effect):
    """Torque that is a smooth function of the command: y = u exp(even x + odd (|x| - 1) + cubic (x^2 - 1)), x = u / Keq.

    The exponent is limited to the range from -5 to 5.
    """

    name = "torque_curve"
    lacks = "the torque is a different function of the command"
    cause = "any map from pressure to torque without memory"
    citation = "C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE TRA 12 (1996)"
    kind = "actuation_map"
    in_space = False
    flexible = True

    even: float = amplitude(0.1, "1/rad", lower=-8.0, upper=8.0, description="logarithmic gain proportional to the command")
    odd: float = amplitude(
        0.1, "1/rad", lower=-8.0, upper=8.0, description="logarithmic gain proportional to the size of the command"
    )
    cubic: float = amplitude(
        0.1, "1/rad^2", lower=-8.0, upper=8.0, description="logarithmic gain proportional to the square of the command"
    )

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        x = torque / keq
        exponent = p.even * x + p.odd * (np.abs(x) - 1.0) + p.cubic * (x * x - 1.0)
        return torque * np.exp(np.minimum(np.maximum(exponent, -5.0), 5.0)), memory
