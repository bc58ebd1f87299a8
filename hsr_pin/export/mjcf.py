"""Export to MuJoCo (E. Todorov, T. Erez, Y. Tassa, IROS 2012): a file, and a module for laws without MuJoCo elements."""

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

#: Supported major versions of MuJoCo.
VERSIONS = (3, 4)
_ACTUATOR = "property of the actuator"


def to_mjcf(model: CorrectedModel, *, laws: str = "laws", major: int = 4) -> Exported:
    """Return the model as an MJCF file for MuJoCo.

    Args:
        model: model to export.
        laws: name of the module beside the file, for its comments.
        major: major version of MuJoCo.

    Raises:
        InputError: the version is not supported.
    """
    if major not in VERSIONS:
        raise InputError("version of MuJoCo", expected=" or ".join(map(str, VERSIONS)), received=major)
    parts, bodies = sort(model, major), bodies_of(model)
    step, actuators = timestep(model, parts), _actuators(model, bodies, parts)
    strands = [strand for each in parts.elements.values() for strand in each.strands]
    plastic = [strand for strand in strands if strand.yields]
    rest, command = _equilibrium(model), any(effect.acts_through("actuator_response") for effect in parts.command)
    memory = _memory(model, parts)
    module = ""
    mark = ""
    values: dict[str, Any] = {
        "model": model,
        "bodies": bodies,
        "parts": parts,
        "joints": _joints(bodies, parts),
        "springs": [(strand, _tendon(bodies, strand)) for strand in strands],
        "actuators": actuators,
        "step": step,
        "history": int(np.ceil(parts.delay / step)) + 2,
        "rest": _key(bodies, rest),
        "plastic": _plastic(plastic, rest),
        "memory": memory if parts.called or command else 0,
        "law_module": laws,
        "space": model.batch.space,
        "ways": ["x", "y", *(["twist"] if len(bodies.links[0].hinges) > 2 else [])],
    }
    if parts.called or command or plastic:
        values["laws"] = [law_text(e, ("moment", "update") if e.states else ("moment",)) for e in parts.called]
        values["muscles"] = [law_text(e, ("actuator_response",)) for e in parts.command if e.acts_through("actuator_response")]
        functions = [getattr(type(e), hook) for e in parts.called for hook in ("moment", "update")]
        functions += [type(e).actuator_response for e in parts.command]
        values |= {"helpers": helpers(functions), "profile": model.batch.arrays.profile[0], "plastic_names": plastic}
        mark = "hsr_" + hashlib.sha256(repr((model.arm, model.effects)).encode()).hexdigest()[:12]
        module = render("mujoco_laws.py.jinja", **values, mark=mark)
    held, by_module = _contents(model, parts, laws)
    exported = Exported("", module, held, by_module, parts.missing, _needs(model, parts, step, laws, bool(module), major))
    text = render("arm.mjcf.jinja", **values, mark=mark, exported=exported)
    return Exported(text, module, held, by_module, exported.missing, exported.needs)


@dataclass(frozen=True)
class Actuator:
    """Actuator of one component of the torque.

    Attributes:
        name: name of the actuator.
        tendon: name of its tendon.
        pulls: (hinge, coefficient) pairs of the tendon.
        bias: constant torque [N m].
    """

    name: str
    tendon: str
    pulls: tuple[tuple[str, float], ...]
    bias: float


def _actuators(model: CorrectedModel, bodies: Bodies, parts: Parts) -> list[Actuator]:
    """Return the actuators: one in a plane; in space two for each section, towards x and towards y."""
    if not model.batch.space:
        pulls = tuple((link.joint, float(link.share[0])) for link in bodies.links)
        return [Actuator("torque", "muscles", pulls, parts.bias.real)]
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
            found.append(Actuator(f"torque_{name}", f"muscles_{name}", pulls, (parts.bias.real, parts.bias.imag)[k]))
    return found


def _tendon(bodies: Bodies, strand: Strand) -> tuple[tuple[str, float], ...]:
    """Return the (hinge, coefficient) pairs of the tendon of a spring."""
    hinges = {hinge.way: hinge.name for hinge in bodies.links[strand.joint - 1].hinges}
    return tuple((hinges[way], pull) for way, pull in enumerate(strand.pulls) if pull)


def _joints(bodies: Bodies, parts: Parts) -> dict[str, tuple[list[float], list[float], float]]:
    """Return the coefficients of spring and damper and the equilibrium angle [rad] of each hinge, by name."""
    each = list(parts.elements.values())
    soft = math.prod(one.soft for one in each) * (not any(one.springless for one in each))
    equilibrium = sum((complex(one.equilibrium) for one in each), 0j) / (soft or 1.0)
    found = {}
    for i, link in enumerate(bodies.links):
        for hinge in link.hinges:
            bends = hinge.way < 2
            spring, damper = [hinge.spring * (soft if bends else 1.0)], [hinge.damper]
            spring += [term for one in each if bends and len(one.cubic) for term in (0.0, float(one.cubic[i]))]
            damper += [term for one in each if bends and len(one.quadratic) for term in (float(one.quadratic[i]), 0.0)]
            found[hinge.name] = (spring, damper, (equilibrium.real, equilibrium.imag, 0.0)[hinge.way])
    return found


def _equilibrium(model: CorrectedModel) -> Array:
    """Return the equilibrium angles [rad], (N,) or in space (N, 3), without a command; zeros if there is no equilibrium."""
    from hsr_pin.simulation.motion import Engine, default_dynamics

    batch = model.batch
    engine = Engine(batch, default_dynamics(batch.arms, batch.effects))
    nothing = np.zeros((1, model.inputs), dtype=complex) if batch.space else np.zeros(1)
    command = engine.deliver(np.zeros((2, *nothing.shape), dtype=nothing.dtype), nothing, 1.0)
    pose, found = engine.settled(command.initial, np.ones(1, dtype=bool), np.zeros((1, batch.coordinates)))
    angles = np.where(np.abs(pose[0]) < 1e-12, 0.0, pose[0])
    return batch.by_joint(angles if found[0] else np.zeros(batch.coordinates))


def _key(bodies: Bodies, rest: Array) -> list[float]:
    """Return ``qpos`` of a pose (N,) or (N, 3) [rad], in the order of the hinges from base to tip."""
    by_way = rest.reshape(len(bodies.links), -1)
    return [float(by_way[i, hinge.way]) for i, link in enumerate(bodies.links) for hinge in link.hinges]


def _plastic(strands: list[Strand], pose: Array) -> list[float]:
    """Return the plastic stretch [rad] of yielding springs after a motion from straight to a pose, twice for each (MuJoCo)."""
    beyond = [float(pose[s.joint - 1] - np.clip(pose[s.joint - 1], -s.yields, s.yields)) for s in strands]
    return [value for each in beyond for value in (each, each)]


def _memory(model: CorrectedModel, parts: Parts) -> int:
    """Return the number of values that the module stores in ``mjData.userdata``."""
    parts_of_one = 2 if model.batch.space else 1
    joints = model.arm.links * (1 + sum(effect.states for effect in parts.called))
    command = model.inputs * (1 + 2 * sum(effect.memories for effect in parts.command))
    return 3 + parts_of_one * (joints + command)


def _contents(model: CorrectedModel, parts: Parts, laws: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the effects that the file contains and those that the module applies, one sentence each."""
    held, called = [], []
    lost = {line.partition(":")[0] for line in parts.missing}
    ways = {
        "stiffness": "springs that differ along the arm",
        "damping": "dampers that differ along the arm",
        "actuation": "coefficients of the tendon of the actuator",
        "observe": "sites of the markers",
    }
    for effect in model.effects:
        if effect in parts.called or effect in parts.command:
            called.append(f"{effect.name}: law in {laws}.py")
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
    lines = [f"MuJoCo {major} or later, time steps of {1e3 * step:g} ms or less, integrator implicitfast"]
    if parts.called or parts.command:
        lines.append(f"{laws}.py: call install(model) of this module before the first step; otherwise its laws do not act")
    if module:
        lines.append(
            f"to start from a given pose or from equilibrium under a torque, call start(model, data, angles, torque) of {laws}.py"
        )
    elif parts.delay or parts.lag:
        lines.append(
            "to start under a torque, set data.act to it and the actuator's history by mj_initCtrlHistory, if they exist"
        )
    if parts.delay:
        lines.append(
            f"for steps shorter than {1e3 * step:g} ms increase nsample of the actuator, whose delay is {1e3 * parts.delay:g} ms"
        )
    return tuple(lines)
