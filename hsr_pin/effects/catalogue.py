"""The catalogue of all effects, by name."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from hsr_pin.effects.actuator_lag import ActuatorLag
from hsr_pin.effects.added_mass import AddedMass
from hsr_pin.effects.backlash import Backlash
from hsr_pin.effects.bending_stop import BendingStop
from hsr_pin.effects.camera_scale import CameraScale
from hsr_pin.effects.capstan_friction import CapstanFriction
from hsr_pin.effects.damping_gradient import DampingGradient
from hsr_pin.effects.dead_time import DeadTime
from hsr_pin.effects.dry_friction import DryFriction
from hsr_pin.effects.effect import Effect
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.effects.gravity_tilt import GravityTilt
from hsr_pin.effects.hysteresis import Hysteresis
from hsr_pin.effects.length_change import LengthChange
from hsr_pin.effects.marker_offset import MarkerOffset
from hsr_pin.effects.marker_slip import MarkerSlip
from hsr_pin.effects.obstacle import Obstacle
from hsr_pin.effects.one_sided_cable import OneSidedCable
from hsr_pin.effects.partial_bias import PartialBias
from hsr_pin.effects.partial_lag import PartialLag
from hsr_pin.effects.preset_bend import PresetBend
from hsr_pin.effects.quadratic_damping import QuadraticDamping
from hsr_pin.effects.restraint import Restraint
from hsr_pin.effects.ringing_drive import RingingDrive
from hsr_pin.effects.side_force import SideForce
from hsr_pin.effects.soft_spot import SoftSpot
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.effects.stiffening import Stiffening
from hsr_pin.effects.stiffness_gradient import StiffnessGradient
from hsr_pin.effects.tip_mass import TipMass
from hsr_pin.effects.torque_bias import TorqueBias
from hsr_pin.effects.torque_decay import TorqueDecay
from hsr_pin.effects.torque_map import TorqueMap
from hsr_pin.effects.unequal_lag import UnequalLag
from hsr_pin.effects.viscoelastic import Viscoelastic
from hsr_pin.errors import EffectError

#: In the order of reports: properties along the arm, with bending, with time, of the drive, of the surroundings.
EFFECTS: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        StiffnessGradient,
        SoftSpot,
        PresetBend,
        Stiffening,
        BendingStop,
        Backlash,
        DryFriction,
        Hysteresis,
        Viscoelastic,
        QuadraticDamping,
        DampingGradient,
        ActuatorLag,
        UnequalLag,
        PartialLag,
        RingingDrive,
        DeadTime,
        TorqueBias,
        PartialBias,
        TorqueMap,
        TorqueDecay,
        OneSidedCable,
        CapstanFriction,
        GravityTilt,
        TipMass,
        AddedMass,
        Restraint,
        Obstacle,
        SideForce,
        MarkerOffset,
        MarkerSlip,
        LengthChange,
        CameraScale,
    )
}


def laws(*, space: bool) -> tuple[type[Effect], ...]:
    """Return the laws that a planar arm, or an arm in space, may lack: effects first, then flexible laws.

    In space, laws that have a fixed direction in the plane are replaced by their spatial versions.
    """
    if not space:
        return (*EFFECTS.values(), *FLEXIBLE.values())
    replaced = {name for effect in SPATIAL.values() for name in effect.contains}
    return (*(law for name, law in EFFECTS.items() if name not in replaced), *SPATIAL.values(), *FLEXIBLE.values())


def effect_named(name: str) -> type[Effect]:
    """Return an effect by its name: of the catalogue, a flexible law, or an effect of arms in space only.

    Raises:
        EffectError: there is no such effect; the message lists the existing names and the most similar one.
    """
    every = EFFECTS | FLEXIBLE | SPATIAL
    if name not in every:
        raise EffectError(
            "effect", expected=", ".join(EFFECTS), received=repr(name), hint=_nearest(name, EFFECTS) or _nearest(name, every)
        )
    return every[name]


def parse_effect(text: str) -> Effect:
    """Parse an effect from the command line: ``name:parameter=value,option=choice``; other parameters stay neutral.

    Raises:
        EffectError: a name is unknown, a value is invalid or out of bounds, or no value switches the effect on.
    """
    name, _, rest = text.partition(":")
    effect = effect_named(name.strip())
    facts, choices = {fact.name: fact for fact in effect.parameters()}, effect.choices()
    values: dict[str, float | str] = {}
    for item in filter(None, (part.strip() for part in rest.split(","))):
        key, _, value = (part.strip() for part in item.partition("="))
        if key not in facts and key not in choices:
            known = [*facts, *choices]
            raise EffectError(
                f"parameter of {effect.name}", expected=", ".join(known), received=repr(key), hint=_nearest(key, known)
            )
        if key in values:
            raise EffectError(f"{effect.name}.{key}", expected="one value", received="two")
        values[key] = value if key in choices else _number(f"{effect.name}.{key}", value)
    amplitudes = [fact for fact in facts.values() if fact.amplitude]
    if amplitudes and not any(fact.name in values for fact in amplitudes):
        example = f"{effect.name}:" + ",".join(f"{fact.name}={fact.scale:g}" for fact in amplitudes)
        raise EffectError(f"{effect.name}.{amplitudes[0].name}", expected="a value, as in " + example, received="none")
    return effect(**values)


def _number(subject: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise EffectError(subject, expected="a number", received=repr(text)) from None


def _nearest(name: str, known: Iterable[str]) -> str:
    close = get_close_matches(name, list(known), n=1)
    return f"did you mean {close[0]}?" if close else ""
