"""Kinds of physics of each name, and names that are equivalent answers.

A law that differs from the catalogue's form need not carry the catalogue's name, but its kind of physics can be diagnosed.
"""

from __future__ import annotations

#: Kinds of physics, each with a short description of the phenomenon, not of its origin.
KINDS: dict[str, str] = {
    "elastic": "resistance to bending that depends on neither rate, history nor time",
    "damping": "resistance to the rate of bending",
    "friction": "rate-independent memory: friction, hysteresis",
    "creep": "fading memory: relaxation, warming, softening",
    "actuation_time": "a torque that acts at another time than commanded",
    "actuation_map": "a torque of another size or at another place than commanded",
    "mass_gravity": "masses, and the direction of gravity",
    "contact": "forces from the environment",
    "measurement": "differences between the measured and the true place of the arm",
}

#: Name -> its main kind, then other kinds that describe it as well. There is an entry for every law of the plants, and for names
#: that a catalogue may contain later. A form of a law, ``name:variant``, has an entry if its kinds differ from those of its name.
_KINDS_OF: dict[str, tuple[str, ...]] = {
    "actuator_lag": ("actuation_time",),
    "added_mass": ("mass_gravity",),
    "backlash": ("elastic",),
    "base_rotation": ("mass_gravity", "measurement"),
    "base_tilt": ("mass_gravity", "measurement"),
    "bend_at_rest": ("elastic", "actuation_map"),  # a shape, or a permanent moment
    "base_shake": ("measurement", "mass_gravity", "contact"),  # visible in the base markers, acting through inertia
    "bending_stop": ("elastic", "contact"),  # a stop inside the arm
    "camera_scale": ("measurement",),
    "cross_coupling": ("elastic", "actuation_map"),
    "damping_gradient": ("damping",),
    "dead_time": ("actuation_time",),
    "dry_friction": ("friction",),
    "frame_rotation": ("measurement",),
    "frame_turn": ("measurement",),
    "follower_thrust": ("actuation_map", "contact"),  # a force that depends on the command
    "gravity_tilt": ("mass_gravity", "measurement"),  # the base is tilted, and the cameras see the tilt
    "hysteresis": ("friction",),
    "length_change": ("measurement", "elastic"),
    "marker_offset": ("measurement",),
    "markers_beside": ("measurement",),
    "marker_slip": ("measurement",),
    "partial_lag": ("actuation_time",),
    "partial_bias": ("actuation_map", "elastic"),  # a permanent moment, or a shape
    "preset_bend": ("actuation_map", "elastic"),  # a permanent moment, or a shape
    "pulsing_stiffness": ("elastic",),
    "quadratic_damping": ("damping",),
    "obstacle": ("contact",),
    "restraint": ("contact",),
    "ringing_drive": ("actuation_time",),
    "side_force": ("contact",),
    "resting_place": ("actuation_map", "friction"),
    "skew_plane": ("measurement", "actuation_map"),  # motion out of the plane, by skewed actuators or cameras
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
    "warming_arm": ("creep", "elastic"),  # stiffness that falls with time
    # Flexible laws, which stand for their kind and are not named as causes.
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

#: Name or form -> other names that are equivalent answers.
_EQUIVALENT: dict[str, tuple[str, ...]] = {
    "actuator_lag:choked": ("unequal_lag",),
    "actuator_lag:unequal": ("unequal_lag",),
    "added_mass": ("mass_scale",),  # an evenly spread mass equals a heavier arm
    "mass_scale": ("added_mass",),
    "torque_bias:drifting": ("preset_bend",),
    "torque_bias:partial": ("preset_bend", "partial_bias"),
    "torque_bias": ("preset_bend",),
    "bend_at_rest": ("torque_offset",),  # equivalent at a single stiffness
    "torque_offset": ("bend_at_rest",),
    "tether": ("restraint",),
    "wall": ("restraint", "obstacle"),
    "restraint": ("obstacle",),  # the plants by others call a wall, a post, a band and a hose so
    "post_midway": ("obstacle",),
    "floor_under_tip": ("obstacle",),
    "warming_arm": ("keq_drift",),  # a stiffness that changes over the session
}

#: Flexible laws, which stand for their kind.
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

#: Plain parameters of the arm, which are not effects and are not named in a verdict on one recording.
PLAIN_PARAMETERS = ("damping_scale", "gain_drift", "keq_drift", "keq_scale", "mass_scale", "torque_gain")


def kinds_of(law: str) -> tuple[str, ...]:
    """Return the kinds that describe a name or form, the best first; none for an unknown name."""
    return _KINDS_OF.get(law) or _KINDS_OF.get(law.partition(":")[0], ())


def names_of(law: str) -> tuple[str, ...]:
    """Return the right names for a law of the catalogue in some form, its own name first."""
    return (law.partition(":")[0], *_EQUIVALENT.get(law, ()))
