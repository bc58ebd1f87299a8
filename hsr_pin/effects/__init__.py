"""The effects that the nominal model may lack: one file per law, and the table of them all."""

from hsr_pin.effects.catalogue import EFFECTS, effect_named, parse_effect
from hsr_pin.effects.effect import Effect

__all__ = ["EFFECTS", "Effect", "effect_named", "parse_effect"]
