"""The laws of the plants.

- ``actuation``: actuator_lag, dead_time, torque_bias, torque_decay, torque_map
- ``dissipative``: damping_gradient, dry_friction, hysteresis, quadratic_damping, viscoelastic
- ``elastic``: backlash, bending_stop, soft_spot, stiffening, stiffness_gradient
- ``law``: what a law can change
- ``mounting``: added_mass, gravity_tilt, marker_offset, tip_mass
- ``outside``: laws outside of the catalogue
"""

from __future__ import annotations

import numpy as np

from hsr_pin.errors import EffectError

from . import actuation, dissipative, elastic, mounting, outside
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
    outside.FollowerThrust,
    outside.PulsingStiffness,
    outside.SkewPlane,
    outside.SupplyRipple,
    outside.Tether,
    outside.TipGust,
    outside.Wall,
    outside.WarmingArm,
)


def draw(name: str, rng: np.random.Generator) -> Law:
    """A law of either list with random secondary parameters and moderate strength."""
    laws = {**CATALOGUE, **OUTSIDE}
    if name not in laws:
        raise EffectError("law", expected=" or ".join(sorted(laws)), received=name)
    return laws[name].draw(rng)
