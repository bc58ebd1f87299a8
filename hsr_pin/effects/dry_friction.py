"""Coulomb friction that sticks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array

#: Stuck links deflect by SHORTEST [rad of the whole arm] and by level / CONTACT before they slide. Found by trial, as short as a
#: step of 10 ms allows.
SHORTEST, CONTACT = 0.005, 25.0
#: Bending [rad] whose load presses straight links together, where friction goes with the load.
PRELOAD = 0.2
#: Index of the form that does.
LOAD = 1


def presliding(level: Any) -> Any:
    """Bending angle d of the whole arm [rad] over which stuck links deflect before they slide."""
    return SHORTEST + level / CONTACT


@dataclass(frozen=True)
class DryFriction(Effect):
    """m = level Keq z / d, z the elastic deflection: dz = dangle while |z| < d, none beyond; d = SHORTEST + level / CONTACT.

    An elastoplastic (Prandtl) element: it depends on the path, not on the rate, and holds a stuck pose exactly. load: |z| stays
    below d (PRELOAD + |angle|), for what presses on the links grows with what bends them: ``level`` is the coefficient.
    """

    name = "dry_friction"
    lacks = "rate-independent friction at the joints, sticking"
    cause = "backbone links rubbing"
    citation = (
        "L. Prandtl, ZAMM 8 (1928); P. Dupont et al., Single state elastoplastic friction models, IEEE TAC 47 (2002); load: "
        "C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE T-RA 12 (1996)"
    )
    kind = "friction"
    states = 1
    passive = True

    level: float = parameter(
        0.0,
        lower=0.0,
        upper=1.0,
        unit="rad",
        scale=0.05,
        amplitude=True,
        resizes=-1,
        description="friction moment over Keq; of the form load where the arm is bent by 0.8 rad",
    )

    form: str = option("even", "load", description="the same at every bending, or growing with it")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return p.level * bending.keq * bending.memory[0] / presliding(p.level)

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        longest = presliding(p.level)
        if p.form == LOAD:
            longest = longest * (PRELOAD + np.abs(end))
        return limited(memory + (end - start), longest)

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        return IMPLICIT * self.level * keq / presliding(self.level), 0.0
