"""One law for each kind of physics that can bend to what its recordings ask: it stands for the kind, never for a cause.

Each has a few numbers in place of a law's one or two. Where it does clearly better than every law of the catalogue, the kind may
be named and its curve drawn, but no effect.
"""

from hsr_pin.effects.effect import Effect
from hsr_pin.effects.flexible.creep_spectrum import CreepSpectrum
from hsr_pin.effects.flexible.damping_curve import DampingCurve
from hsr_pin.effects.flexible.elastic_curve import ElasticCurve
from hsr_pin.effects.flexible.friction_spectrum import FrictionSpectrum
from hsr_pin.effects.flexible.lag_cascade import LagCascade
from hsr_pin.effects.flexible.torque_curve import TorqueCurve

FLEXIBLE: dict[str, type[Effect]] = {
    effect.name: effect for effect in (ElasticCurve, FrictionSpectrum, CreepSpectrum, DampingCurve, LagCascade, TorqueCurve)
}

__all__ = ["FLEXIBLE"]
