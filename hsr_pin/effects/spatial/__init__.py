"""Effects of arms in space only, and the spatial versions of effects that have a fixed direction in the plane."""

from hsr_pin.effects.effect import Effect
from hsr_pin.effects.spatial.base_tilt import BaseTilt
from hsr_pin.effects.spatial.bend_at_rest import BendAtRest
from hsr_pin.effects.spatial.markers_beside import MarkersBeside
from hsr_pin.effects.spatial.torque_offset import TorqueOffset
from hsr_pin.effects.spatial.torsion_compliance import TorsionCompliance
from hsr_pin.effects.spatial.turned_actuation import TurnedActuation
from hsr_pin.effects.spatial.unequal_stiffness import UnequalStiffness
from hsr_pin.effects.spatial.weak_chamber import WeakChamber

SPATIAL: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        UnequalStiffness,
        BendAtRest,
        TorsionCompliance,
        TurnedActuation,
        WeakChamber,
        TorqueOffset,
        BaseTilt,
        MarkersBeside,
    )
}

__all__ = ["SPATIAL"]
