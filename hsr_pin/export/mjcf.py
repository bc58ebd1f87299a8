"""To MuJoCo (E. Todorov, T. Erez, Y. Tassa, IROS 2012): one file, and a module beside it for laws that it has no element for."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.export.bodies import bodies_of
from hsr_pin.export.elements import Strand
from hsr_pin.export.file import Exported
from hsr_pin.export.law_text import helpers, law_text
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.parts import LINEAR, Parts, sort
from hsr_pin.export.templating import render
from hsr_pin.export.timestep import timestep
from hsr_pin.trajectory import Array

#: Major versions of MuJoCo that files are written for.
VERSIONS = (3, 4)


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
    step = timestep(model, parts)
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
        "strands": strands,
        "joints": _joints(model, parts),
        "ease": sum(each.ease for each in parts.elements.values()),
        "step": step,
        "history": int(np.ceil(parts.delay / step)) + 2,
        "rest": rest,
        "plastic": _plastic(plastic, rest),
        "memory": memory if parts.called or command else 0,
        "law_module": laws,
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


def _joints(model: CorrectedModel, parts: Parts) -> list[tuple[list[float], list[float]]]:
    """Coefficients of spring and damper of each joint, as many as are needed."""
    arrays, rows = model.columns.arrays, []
    replaced = any(each.springless for each in parts.elements.values())
    for i in range(model.arm.links):
        spring = [0.0 if replaced else float(arrays.spring[0, i])]
        damper = [float(arrays.damper[0, i])]
        for each in parts.elements.values():
            if len(each.cubic):
                spring += [0.0, float(each.cubic[i])]
            if len(each.quadratic):
                damper += [float(each.quadratic[i]), 0.0]
        rows.append((spring, damper))
    return rows


def _rest(model: CorrectedModel) -> Array:
    """(N,) [rad] where the arm rests without a command; straight where it rests nowhere."""
    from hsr_pin.simulation.motion import Engine, usual

    columns = model.columns
    engine = Engine(columns, usual(columns.links, columns.space))
    nothing = np.zeros(1)
    command = engine.deliver(np.zeros((2, 1)), nothing, 1.0)
    pose, found = engine.settled(command.initial, np.ones(1, dtype=bool), np.zeros((1, columns.links)))
    angles = np.where(np.abs(pose[0]) < 1e-12, 0.0, pose[0])
    return angles if found[0] else np.zeros(columns.links)


def _plastic(strands: list[Strand], pose: Array) -> list[float]:
    """Plastic stretch of springs that yield once the arm came from straight to a pose, twice for each, as MuJoCo has it."""
    beyond = [float(pose[s.joint - 1] - np.clip(pose[s.joint - 1], -s.yields, s.yields)) for s in strands]
    return [value for each in beyond for value in (each, each)]


def _memory(model: CorrectedModel, parts: Parts) -> int:
    """Numbers that the module keeps in ``mjData.userdata``."""
    joints = model.arm.links * (1 + sum(effect.states for effect in parts.called))
    return 4 + joints + 2 * sum(effect.memories for effect in parts.command)


def _said(model: CorrectedModel, parts: Parts, laws: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What the file holds, and what the module does, one sentence each."""
    held, called = [], []
    lost = {line.partition(":")[0] for line in parts.missing}
    ways = {
        "stiffness": "springs that differ along the arm",
        "damping": "dampers that differ along the arm",
        "actuation": "coefficients of the tendon that carries the torque",
        "arm": "bodies and mount",
        "observe": "sites of the markers",
    }
    for effect in model.effects:
        if effect in parts.called or effect in parts.command:
            called.append(f"{effect.name}: its law, in {laws}.py")
        elif effect.name in parts.elements:
            held.append(f"{effect.name}: {parts.elements[effect.name].remark}")
        elif effect.name in LINEAR and effect.name not in lost:
            held.append(f"{effect.name}: the actuator's own")
        else:
            held += [f"{effect.name}: {text}" for hook, text in ways.items() if effect.acts_through(hook)]
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
