"""Sliders: what can be set, and how far."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log10

from hsr_pin.effects.catalogue import effect_named, laws
from hsr_pin.effects.effect import Effect, formless, neutral
from hsr_pin.identification.part import ARM
from hsr_pin.parameters import Parameter

#: Ends of the sliders of the arm: its stiffness and damping are seldom farther off.
_ARM_ENDS = {"keq_scale": (0.2, 3.0), "damping_scale": (0.02, 5.0), "mass_scale": (0.2, 3.0), "torque_gain": (0.2, 3.0)}
_ARM_LABELS = {
    "keq_scale": "stiffness K",
    "damping_scale": "damping C",
    "mass_scale": "mass",
    "torque_gain": "torque",
}
#: An amplitude's slider goes so many practical sizes from neutral.
_SIZES = 8


@dataclass(frozen=True)
class Slider:
    """One number.

    Attributes:
        name: in the settings.
        label: beside the slider.
        lower, upper, step: of the slider.
        neutral: where it stands at first.
        hint: one line.
    """

    name: str
    label: str
    lower: float
    upper: float
    step: float
    neutral: float
    hint: str


def arm_sliders() -> list[Slider]:
    """Factors on the numbers of the arm."""
    return [
        Slider(name, f"{_ARM_LABELS[name]} \u00d7", *_ARM_ENDS[name], 0.01, ARM[name].neutral, ARM[name].description)
        for name in ARM
    ]


def effects_for(*, space: bool) -> dict[str, type[Effect]]:
    """What an arm in a plane, or in space, may lack, by name; the flexible laws are no causes and have no sliders."""
    kinds = [kind for kind in laws(space=space) if not kind.flexible]
    return {kind.name: kind for kind in kinds if not formless([neutral(kind)], space=space)}


def effect_sliders(name: str) -> list[Slider]:
    """The parameters of an effect."""
    return [_slider(name, fact) for fact in effect_named(name).parameters()]


def readings(kind: type[Effect], *, space: bool) -> dict[str, tuple[str, ...]]:
    """The options of an effect with those of their values that have a form in a plane, or in space."""
    return {
        option: tuple(value for value in values if not formless([neutral(kind, **{option: value})], space=space))
        for option, values in kind.choices().items()
    }


def within(slider: Slider, value: float) -> Slider:
    """The slider, made longer where a value lies beyond its ends."""
    return Slider(
        slider.name, slider.label, min(slider.lower, value), max(slider.upper, value), slider.step, slider.neutral, slider.hint
    )


def _slider(effect: str, fact: Parameter) -> Slider:
    lower, upper = fact.lower, fact.upper
    if fact.amplitude:
        lower, upper = max(lower, fact.neutral - _SIZES * fact.scale), min(upper, fact.neutral + _SIZES * fact.scale)
    unit = "" if fact.unit == "1" else f" [{fact.unit}]"
    step = 10.0 ** floor(log10(fact.scale / 10))
    label = fact.name.replace("_", " ") + unit
    return Slider(f"{effect}.{fact.name}", label, lower, upper, step, fact.neutral, fact.description)
