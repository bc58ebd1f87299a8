"""Commands over time: torques, or pressures with the torques that they produce."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.parameters import finite
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled, step_scenario
from hsr_pin.trajectory import Array, Trajectory, read_only

#: Time at rest before a step [s].
REST = 0.1
#: Longest duration of a run [s].
LONGEST = 3600.0


@dataclass(frozen=True, eq=False)
class Drive:
    """A command for one arm.

    Attributes:
        time: (T,) evenly spaced times [s].
        torque: (T,) torque, held from each sample to the next [N m]; of an arm in space (T, 2), towards x and towards y of the
            base.
        pressures: (T, 2) pressures that produce this torque by Eqs. (4) and (5) [bar]; None if the torque itself is commanded.
    """

    time: Array
    torque: Array
    pressures: Array | None = None

    def __post_init__(self) -> None:
        for name in ("time", "torque", "pressures"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def scenario(self, arm: ArmSpecification, effects: tuple[Effect, ...] = ()) -> Scenario:
        """Return the scenario of an arm under this drive that starts in equilibrium under the first command."""
        start = complex(*self.torque[0]) if self.torque.ndim == 2 else float(self.torque[0])
        return Scenario(arm, self.time, self.torque, Settled(start), effects)

    def towards(self, direction: float) -> Drive:
        """Return this drive for an arm in space, towards a direction from x to y of the base [rad]."""
        direction = finite("direction", direction, "a finite angle [rad]")
        return replace(self, torque=np.outer(self.torque, [np.cos(direction), np.sin(direction)]))

    def noted_in(self, trajectory: Trajectory) -> Trajectory:
        """Return a motion under this drive, with the pressures that caused it."""
        count = len(trajectory.time)
        return replace(trajectory, pressures=None if self.pressures is None else self.pressures[:count])


def torque_step(arm: ArmSpecification, torque: float, duration: float = 3.0) -> Drive:
    """Return a drive with zero torque at first and then a constant torque [N m], up to ``duration`` [s].

    Raises:
        InputError: the torque is not a number, or the duration is too short for a step.
    """
    torque = finite("torque", torque, "a finite number [N m]")
    scenario = step_scenario(arm, torque, rest=REST, duration=checked_duration(duration))
    return Drive(scenario.time, scenario.command.real.reshape(len(scenario.time), -1)[:, 0])


def pressure_step(arm: ArmSpecification, pressures: ArrayLike, duration: float = 3.0) -> Drive:
    """Return a drive with constant pressures (2,) [bar] after an interval at rest.

    The pressures at rest do not bend the arm at its stiffness.

    Raises:
        PressureError: the pressures are out of range, or no pressures give the stiffness.
        InputError: the duration is too short for a step.
    """
    torque = PAPER.torque(pressures, arm.keq)
    neutral = PAPER.pressures_for_torque(arm.keq, 0.0)
    step = torque_step(arm, float(torque), duration)
    resting = step.time < REST - step.time[1] / 2
    held = np.where(resting[:, None], neutral, np.asarray(pressures, dtype=float))
    return Drive(step.time, step.torque, held)


def checked_duration(duration: float) -> float:
    """Return a duration [s] unchanged if it is valid for a run.

    Raises:
        InputError: the duration is invalid.
    """
    if not 2 * REST <= finite("duration", duration, f"{2 * REST:g} to {LONGEST:g} s") <= LONGEST:
        raise InputError("duration", expected=f"{2 * REST:g} to {LONGEST:g} s", received=f"{duration:g}")
    return duration
