"""Where the sliders stand: numbers of the arm, and the parameters of every effect."""

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
    """A model of the arm.

    Attributes:
        values: by name ("keq_scale", "dry_friction.level"); what is not named is neutral.
        options: readings of laws, by name ("hysteresis.form"); what is not named is the default.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, model: CorrectedModel, keq: float, damping: float, mass: float) -> Settings:
        """A model that was found, for recordings that declare these numbers."""
        values = {"keq_scale": model.arm.keq / keq, "mass_scale": model.arm.mass / mass, "torque_gain": model.torque_gain}
        if damping > 0:
            values["damping_scale"] = model.arm.damping / damping
        for effect in model.effects:
            values |= {f"{effect.name}.{fact.name}": float(getattr(effect, fact.name)) for fact in effect.parameters()}
        options = {f"{effect.name}.{name}": value for effect in model.effects for name, value in effect.options}
        return cls(values, options)

    def arm(self, name: str) -> float:
        """An open number of the arm."""
        return self.values.get(name, ARM[name].neutral)

    def acts(self, name: str) -> bool:
        """Whether an effect does anything."""
        facts = [fact for fact in effect_named(name).parameters() if fact.amplitude]
        return any(self.values.get(f"{name}.{fact.name}", fact.neutral) != fact.neutral for fact in facts)

    def effects(self) -> tuple[Effect, ...]:
        """Those that do something."""
        return tuple(self._effect(name, kind) for name, kind in (EFFECTS | SPATIAL).items() if self.acts(name))

    def changed(self, name: str, value: float | str) -> Settings:
        """The same with one number or option changed."""
        if isinstance(value, str):
            return replace(self, options={**self.options, name: value})
        return replace(self, values={**self.values, name: value})

    def _effect(self, name: str, kind: type[Effect]) -> Effect:
        numbers = {fact.name: self.values.get(f"{name}.{fact.name}", fact.neutral) for fact in kind.parameters()}
        words = {option: self.options.get(f"{name}.{option}", choices[0]) for option, choices in kind.choices().items()}
        return kind(**numbers, **words)
