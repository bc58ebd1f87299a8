"""An arm that a controller or a learning algorithm advances step by step: command in, state out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.control.fleet import ArmFleet, FleetState, failure_message
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, PressureError, SimulationFailure, quoted
from hsr_pin.robot.pressure import PAPER, PressureMap
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.integrator import STEP
from hsr_pin.simulation.motion import Dynamics
from hsr_pin.simulation.result import Outcome
from hsr_pin.simulation.scenario import Pose
from hsr_pin.trajectory import Array, Marker

#: Shortest and longest step that can be requested [s].
SHORTEST, LONGEST = 1e-6, 60.0


@dataclass(frozen=True, eq=False, slots=True)
class ArmState:
    """The complete state of an arm between two steps.

    Attributes:
        time: time since the reset [s].
        fleet: the state as a fleet of one arm, with the states of the effects.
        joint: shape of the quantities of one joint: () in the plane, (3,) in space.
    """

    time: float
    fleet: FleetState
    joint: tuple[int, ...] = ()

    @property
    def angles(self) -> Array:
        """Joint angles q (N,) [rad], in space (N, 3); read-only."""
        return self._by_joint(self.fleet.chain[0, 0])

    @property
    def rates(self) -> Array:
        """Joint rates v (N,) [rad/s], in space (N, 3); read-only."""
        return self._by_joint(self.fleet.chain[1, 0])

    @property
    def effect_states(self) -> Array:
        """States (states, N) of the effects in the joints, in the order of those effects, in space (states, N, 3); read-only."""
        return self._by_joint(self.fleet.chain[2:, 0])

    def _by_joint(self, rows: Array) -> Array:
        return rows.reshape(*rows.shape[:-1], -1, *self.joint) if self.joint else rows


class ArmSimulator:
    """One arm with its effects, advanced step by step.

    The motion is exactly that of :func:`hsr_pin.simulate` for the same commands and steps. ``state`` is all that changes.
    :meth:`advance` uses an explicit state instead; copies share nothing. The first use on a machine compiles for half a minute,
    once; ``dynamics="aba"`` starts immediately and takes a hundred times as long per step.

    Args:
        arm: the nominal arm.
        effects: effects in addition to the nominal model, at most one of each type.
        dynamics: "compiled", or "aba" or "rnea" with Pinocchio.
        integrator: a name from ``hsr_pin.simulation.integrator``.
        step: largest step of the integrator [s].
        markers: points to follow; default: base, middle and tip.
        pressure_map: map from pressures to torque, Eqs. (1), (4) and (5).
        torque_range: accepted commands [N m]; default: the torques that hold a weightless arm within its bending limit. In space
            the largest magnitude for each section.
    """

    def __init__(
        self,
        arm: ArmSpecification,
        effects: Sequence[Effect] = (),
        *,
        dynamics: Dynamics = "compiled",
        integrator: str = "extrapolated4",
        step: float = STEP,
        markers: tuple[Marker, ...] = (),
        pressure_map: PressureMap = PAPER,
        torque_range: tuple[float, float] | None = None,
    ) -> None:
        self.arm, self.effects, self.pressure_map = arm, tuple(effects), pressure_map
        self.torque_range = torque_range or (-arm.keq * arm.bending_limit, arm.keq * arm.bending_limit)
        self._options = {"dynamics": dynamics, "integrator": integrator, "step": _checked_time("step", step), "markers": markers}
        self._fleet = ArmFleet([arm], [self.effects], **self._options)  # type: ignore[arg-type]  # the types are those declared above
        self._joint: tuple[int, ...] = (3,) if arm.bending == "space" else ()
        self.state = self.reset()

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The points that :meth:`observe` follows."""
        return self._fleet.markers[0]

    def reset(self, torque: ArrayLike = 0.0, *, pose: Pose | None = None) -> ArmState:
        """Reset the arm to time 0.

        Args:
            torque: previous command [N m], in space (2,), of S sections (2 S,); without a pose the arm is in equilibrium under
                it.
            pose: initial angles and rates to use instead.

        Raises:
            InputError: the torque is out of range, or the pose has another number of joints.
            SimulationFailure: there is no equilibrium, or the arm is beyond its bending limit.
        """
        command = np.array([self._checked_torque(torque)])
        if pose is None:
            fleet, found = self._fleet.settled(command)
            if not found[0]:
                bent = self._bent(ArmState(0.0, fleet, self._joint))
                raise SimulationFailure(failure_message(0.0, bent, Outcome.NO_EQUILIBRIUM), ArmState(0.0, fleet, self._joint))
        else:
            if pose.angles.shape != (self.arm.links, *self._joint):
                expected = f"{self.arm.links} joint angles{' (towards x, towards y, twist)' * bool(self._joint)}"
                raise InputError("start", expected=expected, received=f"shape {pose.angles.shape}")
            assert pose.rates is not None
            fleet = self._fleet.placed(pose.angles.reshape(1, -1), pose.rates.reshape(1, -1), command)
        started = ArmState(0.0, fleet, self._joint)
        if not abs(self._fleet.batch.bends(fleet.chain[0, 0]).sum()) <= self._fleet.limit[0]:
            raise SimulationFailure(failure_message(0.0, self._bent(started)), started)
        self.state = started
        return started

    def step(self, torque: ArrayLike | None = None, *, pressures: ArrayLike | None = None, dt: float = STEP) -> ArmState:
        """Hold a command for ``dt`` [s]: a ``torque`` [N m], or ``pressures`` (2,) [bar] at the arm's stiffness.

        In space a torque has two components for each section, (2 S,) or (S, 2), and pressures are not accepted.

        Raises:
            InputError: the command is not a number or out of range, both or neither are given, or the step is invalid.
            PressureError: the pressures are not numbers or out of range.
            SimulationFailure: the arm exceeded its bending limit or diverged; its ``result``, and ``state``, are those before the
                step.
        """
        if (torque is None) == (pressures is None):
            received = "neither" if torque is None else "both"
            raise InputError("command", expected="a torque [N m] or pressures [bar]", received=received)
        if torque is None:
            if self._joint:
                raise InputError("command", expected="two components of torque [N m], for an arm in space", received="pressures")
            delivered = self.pressure_map.torque(np.asarray(pressures), self.arm.keq)
            if delivered.ndim:
                raise PressureError(
                    "pressures", expected="one P1 and one P2 [bar]", received=f"shape {np.shape(delivered)} of each"
                )
            torque = float(delivered)
        self.state = self.advance(self.state, torque, dt)
        return self.state

    def advance(self, state: ArmState, torque: ArrayLike, dt: float = STEP) -> ArmState:
        """Return the state after a torque [N m] was held for ``dt`` [s] from any state; the simulator's own state is unchanged.

        Raises:
            InputError, SimulationFailure: as :meth:`step`.
        """
        command = np.array([self._checked_torque(torque)])
        fleet, lost = self._fleet.advance(state.fleet, command, _checked_time("dt", dt))
        if lost:
            raise SimulationFailure(failure_message(state.time, self._bent(ArmState(state.time, fleet, self._joint))), state)
        return ArmState(state.time + dt, fleet, self._joint)

    def observe(self, state: ArmState | None = None) -> Array:
        """Return the measured marker positions (M, 3) [m] in the world frame, with measurement effects but without noise."""
        return np.asarray(self._fleet.observe((state or self.state).fleet)[0])

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are built anew from the arguments, with separate workspaces, and copy the state."""
        options = {**self._options, "pressure_map": self.pressure_map, "torque_range": self.torque_range}
        return _restored, (type(self), self.arm, self.effects, options, self.state)

    @staticmethod
    def _bent(state: ArmState) -> Array:
        """Return the bending (N,) [rad] of the joints; in space its magnitude."""
        return np.asarray(np.linalg.norm(state.angles, axis=1)) if state.joint else state.angles

    def _checked_torque(self, torque: ArrayLike) -> Any:
        """Return a valid torque as a number; in space complex, for S > 1 sections (S,)."""
        low, high = self.torque_range
        if self._joint:
            return self._checked_vector(torque, high)
        try:
            value = float(torque)  # type: ignore[arg-type]  # invalid values are rejected below
        except (TypeError, ValueError, OverflowError):
            value = math.nan
        if not low <= value <= high:
            raise InputError("torque", expected=f"{low:.4g} to {high:.4g} N m", received=torque)
        return value

    def _checked_vector(self, torque: ArrayLike, largest: float) -> Any:
        sections = max(1, len(self.arm.sections))
        try:
            parts = np.asarray(torque, dtype=float)
        except (TypeError, ValueError, OverflowError):
            parts = np.full(0, math.nan)
        if parts.ndim == 0 and parts == 0:
            parts = np.zeros(2 * sections)
        fits = parts.shape in ((2 * sections,), (sections, 2))
        if not fits or not (np.hypot(*parts.reshape(sections, 2).T) <= largest).all():
            each = f" for each of {sections} sections" if sections > 1 else ""
            expected = f"two components [N m]{each}, towards x and towards y, up to {largest:.4g} N m together"
            raise InputError("torque", expected=expected, received=quoted(torque))
        found = parts.reshape(sections, 2) @ [1, 1j]
        return found if sections > 1 else complex(found[0])


def _checked_time(name: str, value: float) -> float:
    if not isinstance(value, (int, float, np.number)) or not SHORTEST <= value <= LONGEST:
        raise InputError(name, expected=f"{SHORTEST:g} to {LONGEST:g} s", received=value)
    return value


def _restored(
    kind: type[ArmSimulator], arm: ArmSpecification, effects: tuple[Effect, ...], options: dict[str, Any], state: ArmState
) -> ArmSimulator:
    simulator = kind(arm, effects, **options)
    simulator.state = state
    return simulator
