"""Descriptions, in words and numbers, of the parts of a model that URDF and SDF cannot express."""

from __future__ import annotations

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.export.bodies import Bodies
from hsr_pin.export.model import CorrectedModel
from hsr_pin.obstacles import DISSIPATION, STIFFNESS

#: Number of links from which hinges in space move like rotation vectors within 0.5 mm (checked by a test).
ENOUGH = 10

#: Representation of effects that change bodies, springs, dampers and markers, by hook of the effect.
_REPRESENTED = {
    "arm": "bodies and mount",
    "stiffness": "springs that differ along the arm",
    "damping": "dampers that differ along the arm",
    "observe": "frames of the markers",
}


def friction(model: CorrectedModel) -> float:
    """Return the Coulomb friction of each joint [N m]."""
    return sum(effect.level * model.arm.keq for effect in model.effects if _is_even_friction(effect))  # type: ignore[attr-defined]


def _is_even_friction(effect: Effect) -> bool:
    return effect.name == "dry_friction" and ("form", "even") in effect.options


def held(model: CorrectedModel) -> tuple[str, ...]:
    """Return the effects that the file contains, one sentence each."""
    lines = []
    for effect in model.effects:
        by_hook = _REPRESENTED | {"arm": bodies_are(effect)}
        lines += [f"{effect.name}: {text}" for hook, text in by_hook.items() if effect.acts_through(hook)]
        if _is_even_friction(effect):
            lines.append(f"dry_friction: friction of {friction(model):g} N m at each joint, without presliding deflection")
    return tuple(lines)


def bodies_are(effect: Effect) -> str:
    """Return how an effect that changes the arm itself is represented."""
    return "a third hinge at every joint" if effect.name == "torsion_compliance" else _REPRESENTED["arm"]


def unseen(model: CorrectedModel) -> tuple[str, ...]:
    """Return the effects on the markers that no position of a marker on its link can express, one sentence each."""
    beside, turned = ("moved", "kept"), ("world", "base", "cameras")
    known = {"marker_offset": beside, "markers_beside": beside, "gravity_tilt": turned, "base_tilt": turned}
    lines = []
    for effect in model.effects:
        readings = known.get(effect.name, ())
        if effect.acts_through("observe") and any(value not in readings for _, value in effect.options or (("", ""),)):
            lines.append(f"{effect.name}: its change of the observed positions ({numbers(effect)})")
    return tuple(lines)


def approximate(model: CorrectedModel) -> tuple[str, ...]:
    """Return a sentence on the approximation of joints in space by hinges; nothing for an arm in a plane."""
    if not model.batch.space:
        return ()
    hinges = "hinges in series, in alternating order from joint to joint, in place of the rotation vector of hsr_pin"
    return (f"joints: {hinges}; the error decreases as 1/N^2, and {model.arm.links} links are {_sufficient(model.arm.links)}",)


def contact_law(model: CorrectedModel) -> tuple[str, ...]:
    """Return a sentence on the contact law, which no format has, if there are obstacles."""
    if not model.batch.world.shape[1]:
        return ()
    numbers = "; ".join(f"{row[STIFFNESS]:g} N/m^2, {row[DISSIPATION]:g} s/m" for row in model.batch.world[0])
    return (f"contact law: force per depth and length, and dissipation, of each obstacle: {numbers}; the simulator has its own",)


def _sufficient(links: int) -> str:
    return "enough" if links >= ENOUGH else f"few; use {ENOUGH} or more"


def missing(model: CorrectedModel, bodies: Bodies, *, springs: bool) -> tuple[str, ...]:
    """Return the parts of a model that the file lacks, one sentence each.

    Args:
        model: the exported model.
        bodies: bodies of the model.
        springs: whether the format has springs.
    """
    lines = [*approximate(model), *unseen(model), *contact_law(model)]
    if not springs:
        lines += _springs(model, bodies)
    if bodies.gravity_is_turned:
        why = "flat arm" if model.loaded_arm.mount == "flat" else "gravity_tilt"
        lines.append(f"{why}: set the gravity of the world to ({_row(bodies.gravity)}) m/s^2")
    if model.torque_gain != 1.0:
        lines.append(f"torque_gain: multiply every command by {model.torque_gain:g}")
    share = _row([link.share.sum() for link in bodies.links])
    for effect in model.effects:
        if effect.acts_through("actuation"):
            lines.append(f"{effect.name}: shares of the command at the joints, from base to tip: {share}")
        elif effect.acts_through("obstacle"):
            continue  # a solid of the file
        elif not any(effect.acts_through(hook) for hook in _REPRESENTED) and not _is_even_friction(effect):
            lines.append(f"{effect.name}: {effect.lacks} ({numbers(effect)})")
    return (*lines, *_actuator(model, bodies))


def _springs(model: CorrectedModel, bodies: Bodies) -> list[str]:
    values = _row([link.spring for link in bodies.links])
    axes = " towards x and towards y," if model.batch.space else ""
    lines = [f"springs: a torque of -k times the angle at each joint,{axes} from base to tip k [Nm/rad] = {values}"]
    if twist := [hinge.spring for hinge in bodies.hinges if hinge.way == 2]:
        lines.append(f"torsional springs: a torque of -k times the twist at each joint, k [Nm/rad] = {_row(twist)}")
    return lines


def _actuator(model: CorrectedModel, bodies: Bodies) -> list[str]:
    if not model.batch.space:
        return ["actuator: the same torque, the command [N m], at every joint"]
    both = "two components of torque, the command [N m], on the hinges towards x and towards y"
    if not model.arm.sections:
        return [f"actuator: {both} of every joint"]
    rows = (f"of section {k + 1} {_row([link.share[k] for link in bodies.links])}" for k in range(model.inputs))
    return [f"actuator: {both}; shares at the joints from base to tip: {'; '.join(rows)}"]


def numbers(effect: Effect) -> str:
    """Return the parameters of an effect with their units, and its options, as text."""
    facts = [
        f"{fact.name} {getattr(effect, fact.name):g} {fact.unit if fact.unit != '1' else ''}".strip()
        for fact in effect.parameters()
    ]
    return ", ".join([*facts, *(value for _, value in effect.options)])


def _row(values: object) -> str:
    array = np.asarray(values, dtype=float)
    if array.size > 1 and np.ptp(array) == 0 and array.size > 3:
        return f"{array[0]:g} each"
    return ", ".join(f"{value:g}" for value in array)
