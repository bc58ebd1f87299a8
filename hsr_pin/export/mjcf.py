"""To MuJoCo (E. Todorov, T. Erez, Y. Tassa, IROS 2012): one file, and a module beside it for laws that it has no element for."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.export.bodies import Bodies, bodies_of
from hsr_pin.export.elements import Strand
from hsr_pin.export.file import Exported
from hsr_pin.export.law_text import helpers, law_text
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.parts import Parts, is_linear, sort
from hsr_pin.export.plain import bodies_are
from hsr_pin.export.templating import render
from hsr_pin.export.timestep import timestep
from hsr_pin.trajectory import Array

#: Major versions of MuJoCo that files are written for.
VERSIONS = (3, 4)
_ACTUATOR = "the actuator's own"


def to_mjcf(model: CorrectedModel, *, laws: str = "laws", major: int = 4) -> Exported:
    """The model for MuJoCo.

    Args:
        model: what to write.
        laws: name of the module that will stand beside the file, for its comments.
        major: version of MuJoCo.

    Raises:
        InputError: a version that is not known.
    """
    if major not in VERSIONS:
        raise InputError("version of MuJoCo", expected=" or ".join(map(str, VERSIONS)), received=major)
    parts, bodies = sort(model, major), bodies_of(model)
    step, actuators = timestep(model, parts), _muscles(model, bodies, parts)
    strands = [strand for each in parts.elements.values() for strand in each.strands]
    plastic = [strand for strand in strands if strand.yields]
    rest, command = _rest(model), any(effect.acts_through("respond") for effect in parts.command)
    memory = _memory(model, parts)
    module = ""
    mark = ""
    values: dict[str, Any] = {
        "model": model,
        "bodies": bodies,
        "parts": parts,
        "joints": _joints(bodies, parts),
        "springs": [(strand, _strung(bodies, strand)) for strand in strands],
        "actuators": actuators,
        "step": step,
        "history": int(np.ceil(parts.delay / step)) + 2,
        "rest": _key(bodies, rest),
        "plastic": _plastic(plastic, rest),
        "memory": memory if parts.called or command else 0,
        "law_module": laws,
        "space": model.columns.space,
        "ways": ["x", "y", *(["twist"] if len(bodies.links[0].hinges) > 2 else [])],
    }
    if parts.called or command or plastic:
        values["laws"] = [law_text(e, ("moment", "update") if e.states else ("moment",)) for e in parts.called]
        values["muscles"] = [law_text(e, ("respond",)) for e in parts.command if e.acts_through("respond")]
        functions = [getattr(type(e), hook) for e in parts.called for hook in ("moment", "update")]
        functions += [type(e).respond for e in parts.command]
        values |= {"helpers": helpers(functions), "profile": model.columns.arrays.profile[0], "plastic_names": plastic}
        mark = "hsr_" + hashlib.sha256(repr((model.arm, model.effects)).encode()).hexdigest()[:12]
        module = render("mujoco_laws.py.jinja", **values, mark=mark)
    held, by_module = _said(model, parts, laws)
    exported = Exported("", module, held, by_module, parts.missing, _needs(model, parts, step, laws, bool(module), major))
    text = render("arm.mjcf.jinja", **values, mark=mark, exported=exported)
    return Exported(text, module, held, by_module, exported.missing, exported.needs)


@dataclass(frozen=True)
class Muscle:
    """One component of the torque that the muscles give.

    Attributes:
        name: of the actuator.
        tendon: that carries it.
        pulls: (hinge, coefficient) of that tendon.
        bias: [N m] that is always there.
    """

    name: str
    tendon: str
    pulls: tuple[tuple[str, float], ...]
    bias: float


def _muscles(model: CorrectedModel, bodies: Bodies, parts: Parts) -> list[Muscle]:
    """In a plane one; in space two for each section, towards x and towards y."""
    if not model.columns.space:
        pulls = tuple((link.joint, float(link.share[0])) for link in bodies.links)
        return [Muscle("torque", "muscles", pulls, parts.bias.real)]
    found = []
    for section in range(model.inputs):
        for k, unit in enumerate((1.0, 1.0j)):
            way, name = parts.turn * unit, "_".join([*([str(section + 1)] if model.inputs > 1 else []), "xy"[k]])
            pulls = tuple(
                (hinge.name, (way.real, way.imag)[hinge.way] * float(link.share[section]))
                for link in bodies.links
                for hinge in link.hinges
                if hinge.way < 2 and link.share[section]
            )
            found.append(Muscle(f"torque_{name}", f"muscles_{name}", pulls, (parts.bias.real, parts.bias.imag)[k]))
    return found


def _strung(bodies: Bodies, strand: Strand) -> tuple[tuple[str, float], ...]:
    """(hinge, coefficient) of the tendon on which a spring hangs."""
    hinges = {hinge.way: hinge.name for hinge in bodies.links[strand.joint - 1].hinges}
    return tuple((hinges[way], pull) for way, pull in enumerate(strand.pulls) if pull)


def _joints(bodies: Bodies, parts: Parts) -> dict[str, tuple[list[float], list[float], float]]:
    """Of each hinge: coefficients of spring and damper, as many as are needed, and the angle at which the spring is at ease."""
    each = list(parts.elements.values())
    soft = math.prod(one.soft for one in each) * (not any(one.springless for one in each))
    ease = sum((complex(one.ease) for one in each), 0j) / (soft or 1.0)
    found = {}
    for i, link in enumerate(bodies.links):
        for hinge in link.hinges:
            bends = hinge.way < 2
            spring, damper = [hinge.spring * (soft if bends else 1.0)], [hinge.damper]
            spring += [term for one in each if bends and len(one.cubic) for term in (0.0, float(one.cubic[i]))]
            damper += [term for one in each if bends and len(one.quadratic) for term in (float(one.quadratic[i]), 0.0)]
            found[hinge.name] = (spring, damper, (ease.real, ease.imag, 0.0)[hinge.way])
    return found


def _rest(model: CorrectedModel) -> Array:
    """(N,), in space (N, 3), [rad] where the arm rests without a command; straight where it rests nowhere."""
    from hsr_pin.simulation.motion import Engine, usual

    columns = model.columns
    engine = Engine(columns, usual(columns.links, columns.space))
    nothing = np.zeros((1, model.inputs), dtype=complex) if columns.space else np.zeros(1)
    command = engine.deliver(np.zeros((2, *nothing.shape), dtype=nothing.dtype), nothing, 1.0)
    pose, found = engine.settled(command.initial, np.ones(1, dtype=bool), np.zeros((1, columns.coordinates)))
    angles = np.where(np.abs(pose[0]) < 1e-12, 0.0, pose[0])
    return columns.by_joint(angles if found[0] else np.zeros(columns.coordinates))


def _key(bodies: Bodies, rest: Array) -> list[float]:
    """``qpos`` of a pose (N,) or (N, 3) [rad]: hinge by hinge, from the base on."""
    by_way = rest.reshape(len(bodies.links), -1)
    return [float(by_way[i, hinge.way]) for i, link in enumerate(bodies.links) for hinge in link.hinges]


def _plastic(strands: list[Strand], pose: Array) -> list[float]:
    """Plastic stretch of springs that yield once the arm came from straight to a pose, twice for each, as MuJoCo has it."""
    beyond = [float(pose[s.joint - 1] - np.clip(pose[s.joint - 1], -s.yields, s.yields)) for s in strands]
    return [value for each in beyond for value in (each, each)]


def _memory(model: CorrectedModel, parts: Parts) -> int:
    """Numbers that the module keeps in ``mjData.userdata``."""
    parts_of_one = 2 if model.columns.space else 1
    joints = model.arm.links * (1 + sum(effect.states for effect in parts.called))
    command = model.inputs * (1 + 2 * sum(effect.memories for effect in parts.command))
    return 3 + parts_of_one * (joints + command)


def _said(model: CorrectedModel, parts: Parts, laws: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What the file holds, and what the module does, one sentence each."""
    held, called = [], []
    lost = {line.partition(":")[0] for line in parts.missing}
    ways = {
        "stiffness": "springs that differ along the arm",
        "damping": "dampers that differ along the arm",
        "actuation": "coefficients of the tendon that carries the torque",
        "observe": "sites of the markers",
    }
    for effect in model.effects:
        if effect in parts.called or effect in parts.command:
            called.append(f"{effect.name}: its law, in {laws}.py")
        elif effect.name in parts.elements:
            held.append(f"{effect.name}: {parts.elements[effect.name].remark}")
        elif is_linear(effect) and effect.name not in lost:
            turned = effect.name == "turned_actuation"
            held.append(f"{effect.name}: {ways['actuation'] if turned else _ACTUATOR}")
        else:
            own = ways | {"arm": bodies_are(effect)}
            held += [f"{effect.name}: {text}" for hook, text in own.items() if effect.acts_through(hook)]
    if model.torque_gain != 1.0:
        held.append(f"torque_gain {model.torque_gain:g}: gain of the actuator")
    return tuple(held), tuple(called)


def _needs(model: CorrectedModel, parts: Parts, step: float, laws: str, module: bool, major: int) -> tuple[str, ...]:
    lines = [f"MuJoCo {major} or later, at steps of {1e3 * step:g} ms or less, implicitfast"]
    if parts.called or parts.command:
        lines.append(f"{laws}.py: call its install(model) before the first step; without it those laws do not act")
    if module:
        lines.append(
            f"to start from a pose of your own, or settled under a torque: start(model, data, angles, torque) of {laws}.py"
        )
    elif parts.delay or parts.lag:
        lines.append(
            "started under a torque: set data.act to it, and the actuator's history by mj_initCtrlHistory, where it has them"
        )
    if parts.delay:
        lines.append(
            f"with steps shorter than {1e3 * step:g} ms raise nsample of the actuator: its delay is {1e3 * parts.delay:g} ms"
        )
    return tuple(lines)
