"""Definition of the sliders and their ranges."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log10

from hsr_pin.effects.catalogue import effect_named, laws
from hsr_pin.effects.effect import Effect, neutral, unsupported_laws
from hsr_pin.identification.part import ARM
from hsr_pin.parameters import Parameter

#: Ranges of the sliders of the arm, which rarely differs more from its declaration.
_ARM_ENDS = {"keq_scale": (0.2, 3.0), "damping_scale": (0.02, 5.0), "mass_scale": (0.2, 3.0), "torque_gain": (0.2, 3.0)}
_ARM_LABELS = {
    "keq_scale": "stiffness K",
    "damping_scale": "damping C",
    "mass_scale": "mass",
    "torque_gain": "torque",
}
#: Range of the slider of an amplitude, in practical sizes from neutral.
_SIZES = 8


@dataclass(frozen=True)
class Slider:
    """Slider of one number.

    Attributes:
        name: name of the number in the settings.
        label: text beside the slider.
        lower, upper, step: range and step of the slider.
        neutral: initial value.
        hint: description in one line.
    """

    name: str
    label: str
    lower: float
    upper: float
    step: float
    neutral: float
    hint: str


def arm_sliders() -> list[Slider]:
    """Return the sliders for factors on the numbers of the arm."""
    return [
        Slider(name, f"{_ARM_LABELS[name]} \u00d7", *_ARM_ENDS[name], 0.01, ARM[name].neutral, ARM[name].description)
        for name in ARM
    ]


def effects_for(*, space: bool) -> dict[str, type[Effect]]:
    """Return the effects of an arm in a plane or in space, by name, except for flexible laws, which are not causes."""
    kinds = [kind for kind in laws(space=space) if not kind.flexible]
    return {kind.name: kind for kind in kinds if not unsupported_laws([neutral(kind)], space=space)}


def effect_sliders(name: str) -> list[Slider]:
    """Return the sliders for the parameters of an effect."""
    return [_slider(name, fact) for fact in effect_named(name).parameters()]


def variants(kind: type[Effect], *, space: bool) -> dict[str, tuple[str, ...]]:
    """Return the options of an effect with the values that are supported in a plane or in space."""
    return {
        option: tuple(value for value in values if not unsupported_laws([neutral(kind, **{option: value})], space=space))
        for option, values in kind.choices().items()
    }


def with_value(slider: Slider, value: float) -> Slider:
    """Return a slider whose range is extended to contain a value."""
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
