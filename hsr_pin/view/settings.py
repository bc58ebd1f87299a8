"""Values of the sliders: numbers of the arm and parameters of the effects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from hsr_pin.effects.catalogue import EFFECTS, effect_named
from hsr_pin.effects.effect import Effect
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.export.model import CorrectedModel
from hsr_pin.identification.part import ARM


@dataclass(frozen=True)
class Settings:
    """Model of the arm, given by the values of the sliders.

    Attributes:
        values: values by name ("keq_scale", "dry_friction.level"); values that are not given are neutral.
        options: variants of laws by name ("hysteresis.form"); options that are not given have their defaults.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, model: CorrectedModel, keq: float, damping: float, mass: float) -> Settings:
        """Return the settings of a model, relative to declared stiffness [Nm/rad], damping [Nm s/rad] and mass [kg]."""
        values = {"keq_scale": model.arm.keq / keq, "mass_scale": model.arm.mass / mass, "torque_gain": model.torque_gain}
        if damping > 0:
            values["damping_scale"] = model.arm.damping / damping
        for effect in model.effects:
            values |= {f"{effect.name}.{fact.name}": float(getattr(effect, fact.name)) for fact in effect.parameters()}
        options = {f"{effect.name}.{name}": value for effect in model.effects for name, value in effect.options}
        return cls(values, options)

    def arm(self, name: str) -> float:
        """Return the value of a number of the arm."""
        return self.values.get(name, ARM[name].neutral)

    def acts(self, name: str) -> bool:
        """Return whether an effect is active, that is not neutral."""
        facts = [fact for fact in effect_named(name).parameters() if fact.amplitude]
        return any(self.values.get(f"{name}.{fact.name}", fact.neutral) != fact.neutral for fact in facts)

    def effects(self) -> tuple[Effect, ...]:
        """Return the active effects."""
        return tuple(self._effect(name, kind) for name, kind in (EFFECTS | SPATIAL).items() if self.acts(name))

    def changed(self, name: str, value: float | str) -> Settings:
        """Return the settings with one number or option changed."""
        if isinstance(value, str):
            return replace(self, options={**self.options, name: value})
        return replace(self, values={**self.values, name: value})

    def _effect(self, name: str, kind: type[Effect]) -> Effect:
        numbers = {fact.name: self.values.get(f"{name}.{fact.name}", fact.neutral) for fact in kind.parameters()}
        words = {option: self.options.get(f"{name}.{option}", choices[0]) for option, choices in kind.choices().items()}
        return kind(**numbers, **words)
