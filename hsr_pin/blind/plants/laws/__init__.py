"""Laws of the plants: the physics that the nominal model may lack.

- ``actuation``: actuator_lag, dead_time, torque_bias, torque_decay, torque_map
- ``dissipative``: damping_gradient, dry_friction, hysteresis, quadratic_damping, viscoelastic
- ``elastic``: backlash, bending_stop, soft_spot, stiffening, stiffness_gradient
- ``forms``: laws of the catalogue in forms that are not the catalogue's own
- ``law``: what a law can change
- ``mounting``: added_mass, gravity_tilt, marker_offset, tip_mass
- ``outside``: laws outside of the catalogue
- ``session``: what changes between recordings: plain parameters, where the arm comes to rest
"""

from __future__ import annotations

import numpy as np

from hsr_pin.errors import EffectError

from . import actuation, dissipative, elastic, mounting, outside, session
from .forms import actuation as actuation_forms
from .forms import damping as damping_forms
from .forms import elastic as elastic_forms
from .forms import friction as friction_forms
from .forms import mounting as mounting_forms
from .law import Law


def _by_name(*laws: type[Law]) -> dict[str, type[Law]]:
    return {law.name: law for law in sorted(laws, key=lambda law: law.name)}


CATALOGUE: dict[str, type[Law]] = _by_name(
    actuation.ActuatorLag,
    actuation.DeadTime,
    actuation.TorqueBias,
    actuation.TorqueDecay,
    actuation.TorqueMap,
    dissipative.DampingGradient,
    dissipative.DryFriction,
    dissipative.Hysteresis,
    dissipative.QuadraticDamping,
    dissipative.Viscoelastic,
    elastic.Backlash,
    elastic.BendingStop,
    elastic.SoftSpot,
    elastic.Stiffening,
    elastic.StiffnessGradient,
    mounting.AddedMass,
    mounting.GravityTilt,
    mounting.MarkerOffset,
    mounting.TipMass,
)

OUTSIDE: dict[str, type[Law]] = _by_name(
    outside.BaseShake,
    outside.CameraScale,
    outside.FollowerThrust,
    outside.MarkerSlip,
    outside.PulsingStiffness,
    outside.SkewPlane,
    outside.SupplyRipple,
    outside.Tether,
    outside.TipGust,
    outside.Wall,
    outside.WarmingArm,
)


#: Laws of the catalogue in other forms, by ``name:variant``.
FORMS: dict[str, type[Law]] = {
    f"{law.name}:{law.variant}": law
    for law in (
        actuation_forms.ChokedLag,
        actuation_forms.SecondOrderLag,
        actuation_forms.UnequalLag,
        mounting_forms.GrowingMass,
        mounting_forms.HalfHose,
        elastic_forms.LocalPlay,
        elastic_forms.SmoothPlay,
        elastic_forms.GradualStop,
        elastic_forms.ImpactStop,
        damping_forms.CuffDamping,
        damping_forms.ExponentialDamping,
        actuation_forms.JitteredDelay,
        actuation_forms.RestartedDelay,
        friction_forms.BaseFriction,
        friction_forms.LoadFriction,
        friction_forms.StribeckFriction,
        mounting_forms.Remounted,
        mounting_forms.SaggingMount,
        friction_forms.Preisach,
        friction_forms.SkewedLoop,
        mounting_forms.SlidingSleeve,
        mounting_forms.UnevenPlates,
        damping_forms.OneWayDamping,
        damping_forms.PowerDamping,
        elastic_forms.BoxSpot,
        elastic_forms.CrackedSpot,
        elastic_forms.Quintic,
        elastic_forms.Saturating,
        elastic_forms.TaperedRadius,
        elastic_forms.TwoSections,
        mounting_forms.Overhang,
        mounting_forms.Ring,
        actuation_forms.DriftingBias,
        actuation_forms.PartialBias,
        actuation_forms.ParabolicTorque,
        actuation_forms.ShortMuscles,
        actuation_forms.SaturatingMap,
        actuation_forms.ThresholdMap,
        damping_forms.PowerLawCreep,
        damping_forms.Relaxations,
    )
}

#: Laws for changes of the arm's plain parameters between two recordings.
PARAMETERS: dict[str, type[Law]] = _by_name(
    session.DampingScale,
    session.KeqScale,
    session.MassScale,
    session.TorqueGain,
)


def draw(name: str, rng: np.random.Generator) -> Law:
    """Return a law of any list by its name or ``name:variant``, with random secondary parameters and moderate strength."""
    laws = {**CATALOGUE, **OUTSIDE, **FORMS, **PARAMETERS}
    if name not in laws:
        raise EffectError("law", expected=" or ".join(sorted(laws)), received=name)
    return laws[name].draw(rng)
