"""Effects that the nominal model may lack: one file per law, and a catalogue of all effects."""

from hsr_pin.effects.catalogue import EFFECTS, effect_named, parse_effect
from hsr_pin.effects.effect import Effect

__all__ = ["EFFECTS", "Effect", "effect_named", "parse_effect"]
