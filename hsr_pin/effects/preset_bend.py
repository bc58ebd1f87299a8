"""An arm that is bent without torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import amplitude


@dataclass(frozen=True)
class PresetBend(Effect):
    """Bending of the relaxed arm by angle0: m = -k angle0."""

    name = "preset_bend"
    lacks = "the relaxed arm is bent"
    cause = "moulding, creep under its own weight, tubes that pull"
    citation = "D. Trivedi, A. Lotfi, C. D. Rahn, Geometrically exact models for soft robotic manipulators, IEEE TRO 24 (2008)"
    kind = "elastic"
    passive = True

    angle: float = amplitude(0.05, "rad", lower=-1.5, upper=1.5, description="bending of the whole relaxed arm")

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        return -p.angle * bending.keq * bending.stiffness + 0.0 * bending.angle
