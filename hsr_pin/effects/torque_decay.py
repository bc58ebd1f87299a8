"""Actuation that decreases or increases along the arm."""

from __future__ import annotations

from dataclasses import dataclass

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class TorqueDecay(Effect):
    """Linear decrease of the torque along the arm: tau(s) / tau = 1 - decay s."""

    name = "torque_decay"
    lacks = "actuation decreases (or increases) along the arm"
    cause = "friction of the muscle along the backbone"
    citation = "D. B. Camarillo et al., Mechanics modeling of tendon-driven continuum manipulators, IEEE Trans. Robot. 24 (2008)"
    kind = "actuation_map"

    decay: float = amplitude(0.1, "1", lower=-1.0, upper=1.0, description="share of the torque that is lost at the tip")

    def actuation(self, s: Array) -> Array:
        return 1 - self.decay * s
