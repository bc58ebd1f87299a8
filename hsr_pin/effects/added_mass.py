"""Additional mass along the arm."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.robot.specification import ArmSpecification


@dataclass(frozen=True)
class AddedMass(Effect):
    """Mass distributed uniformly along the arm, in addition to the arm's own."""

    name = "added_mass"
    lacks = "extra mass along the arm"
    cause = "pneumatic tubes"
    citation = "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, Van Nostrand Reinhold (1979)"
    kind = "mass_gravity"
    passive = True

    mass: float = amplitude(0.1, "kg", lower=0.0, upper=0.5, description="mass, distributed along the arm")

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        return replace(specification, mass=specification.mass + self.mass)
