"""Coulomb friction with sticking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import IMPLICIT, Bending, Effect, option
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array

#: Stuck links deflect by SHORTEST [rad of the whole arm] plus level / CONTACT before they slide. The values were found by trial;
#: they are as small as a step of 10 ms allows.
SHORTEST, CONTACT = 0.005, 25.0
#: Bending [rad] that is equivalent to the contact load of straight links, for friction that grows with the load.
PRELOAD = 0.2
#: Index of the form "load".
LOAD = 1


def presliding(level: Any) -> Any:
    """Return the bending [rad] of the whole arm by which stuck links deflect before they slide."""
    return SHORTEST + level / CONTACT


@dataclass(frozen=True)
class DryFriction(Effect):
    """Dry friction in the joints with elastic presliding: m = level Keq z / d.

    z is the elastic deflection: dz = dangle while |z| < d, constant beyond; d = SHORTEST + level / CONTACT. This elastoplastic
    (Prandtl) element depends on the path, not on the rate, and holds a stuck pose exactly. In the form "load", |z| stays below d
    (PRELOAD + |angle|), because the contact load grows with bending; ``level`` is then the coefficient.
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

    level: float = amplitude(
        0.05,
        "rad",
        lower=0.0,
        upper=1.0,
        level_exponent=-1,
        description="friction moment relative to Keq; in the form load at a bending of 0.8 rad",
    )

    form: str = option("even", "load", description="constant friction, or friction that grows with bending")

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
