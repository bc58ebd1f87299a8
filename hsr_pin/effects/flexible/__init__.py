"""Flexible laws that adapt to recordings, one or two for each kind of physics; they represent the kind, never a cause.

Each has more parameters than the laws of the catalogue. If a flexible law is clearly better than every law of the catalogue, a
diagnosis may name the kind of physics and draw its curve, but names no effect.
"""

from hsr_pin.effects.effect import Effect
from hsr_pin.effects.flexible.creep_spectrum import CreepSpectrum
from hsr_pin.effects.flexible.damping_curve import DampingCurve
from hsr_pin.effects.flexible.damping_profile import DampingProfile
from hsr_pin.effects.flexible.elastic_curve import ElasticCurve
from hsr_pin.effects.flexible.friction_spectrum import FrictionSpectrum
from hsr_pin.effects.flexible.lag_cascade import LagCascade
from hsr_pin.effects.flexible.marker_profile import MarkerProfile
from hsr_pin.effects.flexible.stiffness_profile import StiffnessProfile
from hsr_pin.effects.flexible.torque_curve import TorqueCurve
from hsr_pin.effects.flexible.torque_profile import TorqueProfile

FLEXIBLE: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        ElasticCurve,
        StiffnessProfile,
        FrictionSpectrum,
        CreepSpectrum,
        DampingCurve,
        DampingProfile,
        LagCascade,
        TorqueCurve,
        TorqueProfile,
        MarkerProfile,
    )
}

__all__ = ["FLEXIBLE"]
