"""Assignment of the effects of a model to MuJoCo elements, to a Python module, or to neither."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import EffectError
from hsr_pin.export.elements import Elements, elements_of
from hsr_pin.export.law_text import helpers
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.plain import approximate, contact_law, numbers, unseen

#: Effects on the command that the MuJoCo actuator can express, in series.
_LINEAR = {"actuator_lag", "torque_bias", "torque_offset", "turned_actuation", "dead_time"}


def is_linear(effect: Effect) -> bool:
    """Return whether the MuJoCo actuator, whose filter is of first order, can express an effect."""
    return effect.name in _LINEAR and dict(effect.options).get("order", "first") == "first"


@dataclass(frozen=True, eq=False)
class Parts:
    """Effects of a model, grouped by their representation in MuJoCo.

    Attributes:
        elements: MuJoCo elements, by effect.
        called: effects in the joints whose laws the module calls.
        command: effects whose laws the module applies to the command; empty: the actuator expresses them.
        delay: delay of the command [s].
        lag: time constant of the actuator [s].
        bias: constant torque of the actuator [N m]; in space complex, towards x and towards y.
        turn: complex number of modulus one by which the torque is rotated.
        missing: effects that are lost, one sentence each.
    """

    elements: dict[str, Elements]
    called: tuple[Effect, ...]
    command: tuple[Effect, ...]
    delay: float
    lag: float
    bias: complex
    turn: complex
    missing: tuple[str, ...]


def sort(model: CorrectedModel, major: int) -> Parts:
    """Assign the effects of a model to elements of a major version of MuJoCo, to the module, or to the list of missing ones."""
    elements: dict[str, Elements] = {}
    called, missing = [], [*approximate(model), *unseen(model), *contact_law(model)]
    for effect in model.effects:
        if effect.acts_through("moment"):
            native = elements_of(effect, model, major=major)
            if native is not None:
                elements[effect.name] = native
            elif np.max(effect.tangent(np.full(1, model.arm.keq), np.full(1, model.arm.length))[1]) > 0:
                why = f"no damper of MuJoCo {major} can express it, and without a damper no time step is short enough"
                missing.append(f"{effect.name}: {why} ({numbers(effect)})")
            else:
                called.append(effect)
        elif effect.acts_through("contact_force"):
            missing.append(f"{effect.name}: add the contact of the arm to the world of MuJoCo ({numbers(effect)})")
    muscles = [effect for effect in model.batch.actuator_effects if any(_is_on(effect))]
    delay = float(sum(np.max(effect.command_delay()) for effect in muscles))
    simple = all(map(is_linear, muscles))
    lag = model.effect("actuator_lag")
    turn, bias = _turned(model) if simple else (1.0 + 0.0j, 0.0j)
    if delay and major < 4:
        missing.append(f"dead_time: actuators of MuJoCo {major} have no delay; delay every command by {delay:g} s")
        delay = 0.0
    command = () if simple else tuple(model.effects[i] for i in _places(model, muscles))
    for effect in (*called, *command):
        try:
            helpers([getattr(type(effect), hook) for hook in ("moment", "update", "actuator_response")])
        except EffectError as error:
            missing.append(f"{effect.name}: {error}")
    lost = {line.partition(":")[0] for line in missing} - {
        "contact law",
        "dead_time",
        "marker_offset",
        "markers_beside",
        "gravity_tilt",
        "base_tilt",
    }
    return Parts(
        elements,
        tuple(effect for effect in called if effect.name not in lost),
        tuple(effect for effect in command if effect.name not in lost),
        delay,
        float(lag.time_constant) if simple and lag is not None else 0.0,  # type: ignore[attr-defined]
        bias,
        turn,
        tuple(missing),
    )


def _turned(model: CorrectedModel) -> tuple[complex, complex]:
    """Return a and b of the torque a (u + b) that torque_bias, torque_offset and turned_actuation make of a torque u."""
    turn, given = 1.0 + 0.0j, 0.0 + 0.0j
    acting: list[Any] = list(model.effects)
    for effect in acting:
        if effect.name == "turned_actuation":
            turn, given = turn * np.exp(1j * effect.angle), given * np.exp(1j * effect.angle)
        elif effect.name == "torque_offset":
            given += complex(effect.towards_x, effect.towards_y)
        elif effect.name == "torque_bias":
            given += effect.bias
    return complex(turn), complex(given / turn)


def _places(model: CorrectedModel, muscles: list[Effect]) -> list[int]:
    kinds = {type(effect) for effect in muscles}
    return [i for i, effect in enumerate(model.effects) if type(effect) in kinds and effect.acts_through("actuator_response")]


def _is_on(effect: Effect) -> list[bool]:
    return [bool(np.any(getattr(effect, fact.name) != fact.neutral)) for fact in effect.parameters() if fact.amplitude]
