"""What is handed on: an arm with the effects that were found, and where its markers are."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, quoted
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.scenario import Scenario, standard_markers
from hsr_pin.trajectory import Marker


@dataclass(frozen=True, eq=False)
class CorrectedModel:
    """An arm as a fit or a diagnosis left it.

    Attributes:
        arm: the nominal arm, its stiffness and damping as fitted.
        effects: what acts beside it, at most one of a kind, in the order in which they act on the command.
        torque_gain: torque that arrives over the commanded one.
        markers: the tracked points; default: base, middle and tip.
        name: of the model, a word.
        origin: where it comes from, one sentence each.
    """

    arm: ArmSpecification = field(default_factory=ArmSpecification)
    effects: tuple[Effect, ...] = ()
    torque_gain: float = 1.0
    markers: tuple[Marker, ...] = ()
    name: str = "hybrid_soft_robot"
    origin: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        self.scenario  # noqa: B018  # refuses an effect given twice
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
            raise InputError("markers", expected="a name for each", received=f"{quoted(twice[0])} twice")

    @cached_property
    def scenario(self) -> Scenario:
        """The model at rest for a second, as the simulation takes it."""
        nothing = np.zeros((2, 2 * self.inputs) if self.arm.bending == "space" else 2)
        return Scenario(self.arm, np.array([0.0, 1.0]), nothing, effects=self.effects, markers=self.markers)

    @property
    def inputs(self) -> int:
        """Torques of the arm, in space of two components each."""
        return max(1, len(self.arm.sections))

    @cached_property
    def columns(self) -> Columns:
        """Its springs, dampers and bodies as the simulation has them."""
        return Columns.of([self.scenario])

    @cached_property
    def loaded_arm(self) -> ArmSpecification:
        """The arm with what the effects make of its bodies and its mount."""
        return self.columns.arms.specification(0)

    def effect(self, name: str) -> Effect | None:
        """The effect of that name, if it acts."""
        return next((effect for effect in self.effects if effect.name == name), None)
