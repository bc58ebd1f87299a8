"""Coulomb friction that sticks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array

#: Stuck links deflect by SHORTEST [rad of the whole arm] and by level / CONTACT before they slide. Found by trial, as short as a
#: step of 10 ms allows: for torque steps of 0.5 Nm within 0.7 mm (extrapolated4) and 1.6 mm (ros2) at every level, N = 4 to 32.
SHORTEST, CONTACT = 0.005, 25.0


@dataclass(frozen=True)
class DryFriction(Effect):
    """m = level Keq z / d, z the elastic deflection: dz = dangle while |z| < d, none beyond; d = SHORTEST + level / CONTACT.

    An elastoplastic (Prandtl) element: it depends on the path, not on the rate, and holds a stuck pose exactly.
    """

    name = "dry_friction"
    lacks = "rate-independent friction at the joints, sticking"
    cause = "backbone links rubbing"
    citation = "L. Prandtl, ZAMM 8 (1928); P. Dupont et al., Single state elastoplastic friction models, IEEE TAC 47 (2002)"
    states = 1
    passive = True

    level: float = parameter(
        0.0, lower=0.0, upper=1.0, unit="rad", scale=0.05, amplitude=True, description="friction moment over Keq"
    )

    @property
    def presliding(self) -> Array:
        """Bending angle d of the whole arm [rad] over which stuck links deflect before they slide."""
        return np.asarray(SHORTEST + np.asarray(self.level) / CONTACT)

    def moment(self, bending: Bending) -> Array:
        return np.asarray(self.level * bending.keq * bending.state[0] / self.presliding)

    def tangent(self, keq: Array) -> tuple[Any, Any]:
        return self.level * keq / self.presliding / 2, 0.0

    def update(self, state: Array, start: Array, end: Array, elapsed: float) -> Array:
        return np.clip(state + (end - start), -self.presliding, self.presliding)
