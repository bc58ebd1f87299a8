"""What a simulation gives back, and how it may end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from hsr_pin.errors import SimulationFailure
from hsr_pin.simulation.energy import SUSPICIOUS, Energy, energy, untold
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array, Trajectory


class Outcome(Enum):
    """How a run ended; the value says what to try."""

    COMPLETED = "completed"
    BENDING_LIMIT = "the arm bent beyond its limit; lower the torque or raise the stiffness or the bending limit"
    DIVERGED = "the motion diverged; try a smaller step, or parameters nearer to a real arm's"
    NO_EQUILIBRIUM = "no equilibrium was found to start from; lower the torque or raise the stiffness"


def reason_of(q: Array) -> Outcome:
    """Why a run cannot go on from the joint angles q (N,) [rad], which are beyond the bending limit."""
    far = not np.abs(q).max() <= 4 * np.pi  # nan counts as far
    return Outcome.DIVERGED if far else Outcome.BENDING_LIMIT


def furthest_joint(q: Array) -> int:
    """Number, from 1, of the joint that is bent most; of the first that is not a number, if there is one."""
    return int(np.argmax(np.where(np.isfinite(q), np.abs(q), np.inf))) + 1


@dataclass(frozen=True, eq=False)
class SimulationResult:
    """One run.

    Attributes:
        scenario: what was simulated.
        trajectory: the motion, up to the failure if there was one.
        outcome: how it ended.
        failure_time: [s] of the failure; None if there was none.
        failure_joint: number of the joint that went furthest, from 1; None if there was no failure.
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
        """The energy account of the motion; raises where :func:`hsr_pin.simulation.energy.energy` does."""
        return energy(self.scenario, self.trajectory)

    @property
    def warning(self) -> str:
        """One sentence where the motion gained energy from nowhere; empty where it did not, or where this cannot be told."""
        active = any(effect.acts_through("moment") and not effect.passive for effect in self.scenario.effects)
        rise = 0.0 if active or untold(self.scenario) else self.energy().rise
        if rise <= SUSPICIOUS:
            return ""
        return f"the motion gained {100 * rise:.0f} % of its energy from nowhere; try a smaller tolerance or step"

    def raise_on_failure(self) -> SimulationResult:
        """The result itself, if it is complete.

        Raises:
            SimulationFailure: with this result as its ``result``.
        """
        if self.completed:
            return self
        where = f"at t = {self.failure_time:.4g} s, joint {self.failure_joint}"
        more = f"; {self.warning}" if self.warning else ""
        raise SimulationFailure(f"simulation stopped {where}: {self.outcome.value}{more}", self)
