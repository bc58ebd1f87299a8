"""Effects that only an arm in space has."""

from hsr_pin.effects.effect import Effect
from hsr_pin.effects.spatial.bend_at_rest import BendAtRest

SPATIAL: dict[str, type[Effect]] = {effect.name: effect for effect in (BendAtRest,)}

__all__ = ["SPATIAL"]
