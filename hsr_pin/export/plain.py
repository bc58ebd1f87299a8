"""What URDF and SDF cannot say of a model, in words and numbers that can be carried over by hand."""

from __future__ import annotations

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.export.bodies import Bodies
from hsr_pin.export.model import CorrectedModel

#: Links at which the motion of hinges in space is that of rotation vectors to half a millimetre (a test compares them).
ENOUGH = 10

#: What becomes of effects that change bodies, springs, dampers and markers.
_WAYS = {
    "arm": "bodies and mount",
    "stiffness": "springs that differ along the arm",
    "damping": "dampers that differ along the arm",
    "observe": "frames of the markers",
}


def friction(model: CorrectedModel) -> float:
    """[N m] Coulomb friction of each joint."""
    return sum(effect.level * model.arm.keq for effect in model.effects if _rubs_evenly(effect))  # type: ignore[attr-defined]


def _rubs_evenly(effect: Effect) -> bool:
    return effect.name == "dry_friction" and ("form", "even") in effect.options


def held(model: CorrectedModel) -> tuple[str, ...]:
    """What the file expresses of the effects."""
    lines = []
    for effect in model.effects:
        ways = _WAYS | {"arm": bodies_are(effect)}
        lines += [f"{effect.name}: {text}" for hook, text in ways.items() if effect.acts_through(hook)]
        if _rubs_evenly(effect):
            lines.append(f"dry_friction: friction of {friction(model):g} N m at each joint, without its give before it slides")
    return tuple(lines)


def bodies_are(effect: Effect) -> str:
    """What becomes of an effect that changes the arm itself."""
    return "a third hinge at every joint" if effect.name == "torsion_compliance" else _WAYS["arm"]


def unseen(model: CorrectedModel) -> tuple[str, ...]:
    """What no place of a marker on its link can say."""
    beside, turned = ("moved", "kept"), ("world", "base", "cameras")
    known = {"marker_offset": beside, "markers_beside": beside, "gravity_tilt": turned, "base_tilt": turned}
    lines = []
    for effect in model.effects:
        readings = known.get(effect.name, ())
        if effect.acts_through("observe") and any(value not in readings for _, value in effect.options or (("", ""),)):
            lines.append(f"{effect.name}: what it makes the cameras see ({numbers(effect)})")
    return tuple(lines)


def approximate(model: CorrectedModel) -> tuple[str, ...]:
    """What hinges make of joints in space."""
    if not model.columns.space:
        return ()
    told = "hinges one after the other, in the opposite order from joint to joint, where hsr_pin has a rotation vector"
    return (f"joints: {told}; they come near it as 1/N^2, and {model.arm.links} links are {_near(model.arm.links)}",)


def _near(links: int) -> str:
    return "enough" if links >= ENOUGH else f"few: take {ENOUGH} or more"


def missing(model: CorrectedModel, bodies: Bodies, *, springs: bool) -> tuple[str, ...]:
    """What it does not.

    Args:
        model: what was written.
        bodies: its bodies.
        springs: whether the format has springs.
    """
    lines = [*approximate(model), *unseen(model)]
    if not springs:
        lines += _springs(model, bodies)
    if bodies.gravity_is_turned:
        lines.append(f"gravity_tilt: set the gravity of the world to ({_row(bodies.gravity)}) m/s^2")
    if model.torque_gain != 1.0:
        lines.append(f"torque_gain: multiply every command by {model.torque_gain:g}")
    share = _row([link.share.sum() for link in bodies.links])
    for effect in model.effects:
        if effect.acts_through("actuation"):
            lines.append(f"{effect.name}: of the command, from base to tip the joints get {share}")
        elif not any(effect.acts_through(hook) for hook in _WAYS) and not _rubs_evenly(effect):
            lines.append(f"{effect.name}: {effect.lacks} ({numbers(effect)})")
    return (*lines, *_actuator(model, bodies))


def _springs(model: CorrectedModel, bodies: Bodies) -> list[str]:
    values = _row([link.spring for link in bodies.links])
    axes = " towards x and towards y alike," if model.columns.space else ""
    lines = [f"springs: a torque of -k times the angle at each joint,{axes} from base to tip k [Nm/rad] = {values}"]
    if twist := [hinge.spring for hinge in bodies.hinges if hinge.way == 2]:
        lines.append(f"springs against twisting: likewise, k [Nm/rad] = {_row(twist)}")
    return lines


def _actuator(model: CorrectedModel, bodies: Bodies) -> list[str]:
    if not model.columns.space:
        return ["actuator: the same torque, the command [N m], at every joint"]
    both = "two components of torque, the command [N m], on the hinges towards x and towards y"
    if not model.arm.sections:
        return [f"actuator: {both} of every joint"]
    rows = (f"of section {k + 1} {_row([link.share[k] for link in bodies.links])}" for k in range(model.inputs))
    return [f"actuator: {both}; from base to tip the joints get, {'; '.join(rows)}"]


def numbers(effect: Effect) -> str:
    """The parameters of an effect with their units, and its options."""
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
