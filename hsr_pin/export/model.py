"""Model that is exported: an arm with the effects that were found and its markers."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, quoted
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.scenario import Scenario, standard_markers
from hsr_pin.trajectory import Marker


@dataclass(frozen=True, eq=False)
class CorrectedModel:
    """Arm with the parameters and effects found by a fit or a diagnosis.

    Attributes:
        arm: nominal arm with fitted stiffness and damping.
        effects: additional effects, at most one of each kind, in the order in which they act on the command.
        torque_gain: ratio of the actual to the commanded torque.
        markers: tracked points; default: base, middle and tip.
        name: name of the model, one word.
        origin: sources of the model, one sentence each.
    """

    arm: ArmSpecification = field(default_factory=ArmSpecification)
    effects: tuple[Effect, ...] = ()
    torque_gain: float = 1.0
    markers: tuple[Marker, ...] = ()
    name: str = "hybrid_soft_robot"
    origin: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        self.scenario  # noqa: B018  # checks that no effect is given twice
        if not self.markers:
            object.__setattr__(self, "markers", standard_markers(self.arm.length))
        for marker in self.markers:
            for name in ("arc_length", "radius"):
                value, most = getattr(marker, name), self.arm.length
                if not 0 <= value <= most * (1 + 1e-9):
                    expected = f"from 0 to the arm's length, {most:g} m"
                    raise InputError(f"{name} of marker {marker.name}", expected=expected, received=value)
        names = [marker.name for marker in self.markers]
        if twice := [name for name in names if names.count(name) > 1]:
            raise InputError("markers", expected="a unique name for each marker", received=f"{quoted(twice[0])} twice")

    @cached_property
    def scenario(self) -> Scenario:
        """Scenario of the model at rest for one second, for the simulation."""
        nothing = np.zeros((2, 2 * self.inputs) if self.arm.bending == "space" else 2)
        return Scenario(self.arm, np.array([0.0, 1.0]), nothing, effects=self.effects, markers=self.markers)

    @property
    def inputs(self) -> int:
        """Number of torques of the arm, which in space have two components each."""
        return max(1, len(self.arm.sections))

    @cached_property
    def batch(self) -> ArmBatch:
        """Springs, dampers and bodies of the model as used by the simulation."""
        return ArmBatch.of([self.scenario])

    @cached_property
    def loaded_arm(self) -> ArmSpecification:
        """Arm with the changes of its bodies and its mount by the effects."""
        return self.batch.arms.specification(0)

    def effect(self, name: str) -> Effect | None:
        """Return the effect with a name; None if it is not part of the model."""
        return next((effect for effect in self.effects if effect.name == name), None)
