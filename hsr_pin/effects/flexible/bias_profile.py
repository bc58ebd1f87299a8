"""Any constant moment along the arm that has few waves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter


def _size(description: str) -> Any:
    return parameter(0.0, lower=-1.0, upper=1.0, unit="Nm", scale=0.05, amplitude=True, resizes=1, description=description)


@dataclass(frozen=True)
class BiasProfile(Effect):
    """m(s) = -(even + first P1(x) + second P2(x) + third P3(x)), P the Legendre polynomials of x = 2 s - 1."""

    name = "bias_profile"
    lacks = "a constant moment is added, another at every place of the arm"
    cause = "muscles of unequal length, glued bent or shorter on a part of the arm"
    citation = "R. J. Webster, B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, IJRR 29 (2010)"
    kind = "actuation_map"
    flexible = True

    even: float = _size("mean along the arm")
    first: float = _size("from base to tip")
    second: float = _size("ends against middle")
    third: float = _size("of third order")

    @property
    def in_space(self) -> bool:
        return False

    @property
    def placeless(self) -> bool:
        return False

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        x = 2 * bending.place - 1
        waves = p.first * x + p.second * (1.5 * x * x - 0.5) + p.third * (2.5 * x * x * x - 1.5 * x)
        return -(p.even + waves) + 0.0 * bending.angle
