"""Play: no restoring torque inside a gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.effects.vector import limited
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class Backlash(Effect):
    """Play without restoring torque: m = -k clip(angle, -gap/2, gap/2).

    Together with the spring, this moment makes a dead zone.
    """

    name = "backlash"
    lacks = "no restoring torque inside a gap"
    cause = "play between backbone links"
    citation = "M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash - a survey, Automatica 38 (2002)"
    kind = "elastic"
    passive = True

    gap: float = amplitude(0.05, "rad", lower=0.0, upper=0.8, description="width of the play, as bending of the whole arm")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -bending.keq * bending.stiffness * limited(bending.angle, p.gap / 2)
