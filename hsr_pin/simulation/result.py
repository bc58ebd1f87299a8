"""The result of a simulation and its possible outcomes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from hsr_pin.errors import SimulationFailure
from hsr_pin.simulation.contact_forces import ContactForces, contact_forces
from hsr_pin.simulation.energy import SUSPICIOUS, Energy, energy, energy_obstacle
from hsr_pin.simulation.measures import first_self_contact
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array, Trajectory


class Outcome(Enum):
    """The outcome of a run; the value of a failure suggests a remedy."""

    COMPLETED = "completed"
    BENDING_LIMIT = "the arm bent beyond its limit; lower the torque or raise the stiffness or the bending limit"
    DIVERGED = "the motion diverged; try a smaller step, or parameters closer to those of a real arm"
    NO_EQUILIBRIUM = "no initial equilibrium was found; lower the torque or raise the stiffness"


def reason_of(q: Array) -> Outcome:
    """Return the outcome of a run that stopped at joint angles q (N,) [rad] beyond the bending limit."""
    far = not np.abs(q).max() <= 4 * np.pi  # nan counts as far
    return Outcome.DIVERGED if far else Outcome.BENDING_LIMIT


def furthest_joint(q: Array) -> int:
    """Return the number, from 1, of the joint with the largest angle, or of the first one whose angle is not finite."""
    return int(np.argmax(np.where(np.isfinite(q), np.abs(q), np.inf))) + 1


@dataclass(frozen=True, eq=False)
class SimulationResult:
    """The result of one run.

    Attributes:
        scenario: the simulated scenario.
        trajectory: the motion, up to the failure if there was one.
        outcome: the outcome of the run.
        failure_time: time of the failure [s]; None if there was none.
        failure_joint: number of the joint with the largest angle at the failure, from 1; None if there was no failure.
    """

    scenario: Scenario
    trajectory: Trajectory
    outcome: Outcome = Outcome.COMPLETED
    failure_time: float | None = None
    failure_joint: int | None = None

    @property
    def completed(self) -> bool:
        """Whether the run reached its end."""
        return self.outcome is Outcome.COMPLETED

    def energy(self) -> Energy:
        """Return the energy balance of the motion; raises the errors of :func:`hsr_pin.simulation.energy.energy`."""
        return energy(self.scenario, self.trajectory)

    def contact_forces(self) -> ContactForces:
        """Return the forces of the obstacles on the arm."""
        return contact_forces(self.scenario, self.trajectory)

    @property
    def warning(self) -> str:
        """A sentence that warns of an arm that touches itself, or of an increase of energy; empty if there is no reason to."""
        touch = first_self_contact(self.scenario.arm, self.trajectory)
        if touch is not None:
            return f"the arm passes through itself from {touch:.3g} s on: contact of an arm with itself is not simulated"
        active = any(effect.acts_through("moment") and not effect.passive for effect in self.scenario.effects)
        rise = 0.0 if active or energy_obstacle(self.scenario) else self.energy().rise
        if rise <= SUSPICIOUS:
            return ""
        return f"integration errors added {100 * rise:.0f} % to the energy of the motion; try a smaller tolerance or step"

    def raise_on_failure(self) -> SimulationResult:
        """Return the result itself if the run is complete.

        Raises:
            SimulationFailure: the run failed; the error has this result as its ``result``.
        """
        if self.completed:
            return self
        where = f"at t = {self.failure_time:.4g} s, joint {self.failure_joint}"
        more = f"; {self.warning}" if self.warning else ""
        raise SimulationFailure(f"simulation stopped {where}: {self.outcome.value}{more}", self)
