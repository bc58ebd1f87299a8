"""An arm in space that is stiffer about one axis than about the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class UnequalStiffness(Effect):
    """Bending stiffness that depends on the direction: m = k (e_x + i e_d) conj(x + i y).

    The stiffness is k (1 + e_x) towards x and k (1 - e_x) towards y; e_d acts along the diagonals.
    """

    name = "unequal_stiffness"
    lacks = "the arm bends more easily to some sides than to others"
    cause = "a flat cross section, tubes on two sides, layers of a printed body"
    citation = "D. B. Camarillo et al., Mechanics modeling of tendon-driven continuum manipulators, IEEE Trans. Robot. 24 (2008)"
    kind = "elastic"
    in_plane = False
    passive = True

    along_x: float = amplitude(0.05, "1", lower=-0.6, upper=0.6, description="relative additional stiffness towards x")
    diagonal: float = amplitude(
        0.05, "1", lower=-0.6, upper=0.6, description="relative additional stiffness halfway between x and y"
    )

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return (p.along_x + 1j * p.diagonal) * np.conj(bending.angle) * bending.keq * bending.stiffness

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return IMPLICIT * np.hypot(self.along_x, self.diagonal) * keq, 0.0
