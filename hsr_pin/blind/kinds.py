"""What kind of physics a name stands for, and which names are as good as another: data, in one place.

A law that is not in the catalogue's own form need not carry the catalogue's name, but it is of a kind, and that can be told.
"""

from __future__ import annotations

#: Kinds: what happens, not where it comes from.
KINDS: dict[str, str] = {
    "elastic": "how the arm resists bending, the same whether it comes or goes, soon or late",
    "damping": "resistance to the rate of bending",
    "friction": "memory that knows no rate: friction, hysteresis",
    "creep": "memory that fades: relaxation, warming, softening",
    "actuation_time": "the torque comes when it was not commanded",
    "actuation_map": "the torque is not what was commanded, or not where",
    "mass_gravity": "what is heavy, and which way is down",
    "contact": "the world pushes",
    "measurement": "what the cameras see is not where the arm is",
}

#: Name -> its kind, and after it others that describe it as well. Every law of the plants has one; so have names that a
#: catalogue may come to hold. A form of a law, ``name:variant``, is here if it differs from its name.
_OF: dict[str, tuple[str, ...]] = {
    "actuator_lag": ("actuation_time",),
    "added_mass": ("mass_gravity",),
    "backlash": ("elastic",),
    "base_rotation": ("mass_gravity", "measurement"),
    "base_tilt": ("mass_gravity", "measurement"),
    "bend_at_rest": ("elastic", "actuation_map"),  # a shape, or a moment that is always there
    "base_shake": ("measurement", "mass_gravity", "contact"),  # seen by the base markers, felt as inertia
    "bending_stop": ("elastic", "contact"),  # a stop inside of the arm
    "camera_scale": ("measurement",),
    "cross_coupling": ("elastic", "actuation_map"),
    "damping_gradient": ("damping",),
    "dead_time": ("actuation_time",),
    "dry_friction": ("friction",),
    "frame_rotation": ("measurement",),
    "frame_turn": ("measurement",),
    "follower_thrust": ("actuation_map", "contact"),  # a force that goes with the command
    "gravity_tilt": ("mass_gravity", "measurement"),  # the base is turned; the cameras see it turned
    "hysteresis": ("friction",),
    "length_change": ("measurement", "elastic"),
    "marker_offset": ("measurement",),
    "markers_beside": ("measurement",),
    "marker_slip": ("measurement",),
    "partial_lag": ("actuation_time",),
    "partial_bias": ("actuation_map", "elastic"),  # a moment that is always there, or a shape
    "preset_bend": ("actuation_map", "elastic"),  # a moment that is always there, or a shape
    "pulsing_stiffness": ("elastic",),
    "quadratic_damping": ("damping",),
    "restraint": ("contact",),
    "ringing_drive": ("actuation_time",),
    "side_force": ("contact",),
    "resting_place": ("actuation_map", "friction"),
    "skew_plane": ("measurement", "actuation_map"),  # leaves the plane: muscles askew, or cameras
    "soft_spot": ("elastic",),
    "stiffening": ("elastic",),
    "stiffness_gradient": ("elastic",),
    "supply_ripple": ("actuation_map", "actuation_time"),
    "tether": ("contact",),
    "tip_gust": ("contact",),
    "tip_mass": ("mass_gravity",),
    "torque_offset": ("actuation_map", "elastic"),
    "torsion_compliance": ("elastic",),
    "turned_actuation": ("actuation_map",),
    "unequal_stiffness": ("elastic",),
    "weak_chamber": ("actuation_map",),
    "torque_bias": ("actuation_map",),
    "torque_bias:partial": ("actuation_map", "elastic"),
    "torque_decay": ("actuation_map",),
    "torque_gain": ("actuation_map",),
    "torque_map": ("actuation_map",),
    "unequal_lag": ("actuation_time",),
    "viscoelastic": ("creep",),
    "wall": ("contact",),
    "warming_arm": ("creep", "elastic"),  # stiffness falls, with time
    # Flexible laws: they stand for their kind, and are no names of causes.
    "creep_spectrum": ("creep",),
    "damping_curve": ("damping",),
    "damping_profile": ("damping",),
    "elastic_curve": ("elastic",),
    "friction_spectrum": ("friction",),
    "stiffness_profile": ("elastic",),
    "lag_cascade": ("actuation_time",),
    "marker_profile": ("measurement",),
    "torque_curve": ("actuation_map",),
    "torque_profile": ("actuation_map",),
    # Plain parameters.
    "damping_scale": ("damping",),
    "gain_drift": ("actuation_map",),
    "keq_drift": ("elastic", "creep"),
    "keq_scale": ("elastic",),
    "mass_scale": ("mass_gravity",),
}

#: Name or form -> other names that say the same of it.
_AS_GOOD: dict[str, tuple[str, ...]] = {
    "actuator_lag:choked": ("unequal_lag",),
    "actuator_lag:unequal": ("unequal_lag",),
    "added_mass": ("mass_scale",),  # evenly spread, it is a heavier arm
    "mass_scale": ("added_mass",),
    "torque_bias:drifting": ("preset_bend",),
    "torque_bias:partial": ("preset_bend", "partial_bias"),
    "torque_bias": ("preset_bend",),
    "bend_at_rest": ("torque_offset",),  # at one stiffness
    "torque_offset": ("bend_at_rest",),
    "tether": ("restraint",),
    "wall": ("restraint",),
    "warming_arm": ("keq_drift",),  # a stiffness that changes over the session
}

#: Laws that stand for their kind.
FLEXIBLE = (
    "creep_spectrum",
    "damping_curve",
    "damping_profile",
    "elastic_curve",
    "friction_spectrum",
    "lag_cascade",
    "marker_profile",
    "stiffness_profile",
    "torque_curve",
    "torque_profile",
)

#: Of the arm itself: not effects, and no names in a verdict on one recording.
PLAIN = ("damping_scale", "gain_drift", "keq_drift", "keq_scale", "mass_scale", "torque_gain")


def kinds_of(law: str) -> tuple[str, ...]:
    """Kinds that describe a name or form, the best first; none for a name that nobody here knows."""
    return _OF.get(law) or _OF.get(law.partition(":")[0], ())


def names_of(law: str) -> tuple[str, ...]:
    """Names that are right for a law of the catalogue in some form, its own first."""
    return (law.partition(":")[0], *_AS_GOOD.get(law, ()))
