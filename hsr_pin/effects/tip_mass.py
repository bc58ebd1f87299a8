"""An additional mass at the tip."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.robot.specification import ArmSpecification


@dataclass(frozen=True)
class TipMass(Effect):
    """Point mass at s = 1, in addition to the declared one."""

    name = "tip_mass"
    lacks = "an extra mass at the tip"
    cause = "marker plate, connectors"
    citation = "C. G. Atkeson et al., Estimation of inertial parameters of manipulator loads and links, IJRR 5 (1986)"
    kind = "mass_gravity"
    passive = True

    mass: float = amplitude(0.02, "kg", lower=0.0, upper=0.5, description="additional mass at the tip")

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        return replace(specification, tip_mass=specification.tip_mass + self.mass)
