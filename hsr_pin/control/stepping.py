"""An arm to step by hand, as a controller or a learner does: command in, state out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.control.fleet import ArmFleet, FleetState, failed
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, PressureError, SimulationFailure, quoted
from hsr_pin.robot.pressure import PAPER, PressureMap
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.integrator import STEP
from hsr_pin.simulation.motion import Dynamics
from hsr_pin.simulation.result import Outcome
from hsr_pin.simulation.scenario import Pose
from hsr_pin.trajectory import Array, Marker

#: Shortest and longest step [s] that can be asked for.
SHORTEST, LONGEST = 1e-6, 60.0


@dataclass(frozen=True, eq=False, slots=True)
class ArmState:
    """All there is to know of an arm between two steps.

    Attributes:
        time: [s] since the reset.
        fleet: the same as of a fleet of one, with what the effects remember.
        joint: shape of what is told of one joint: () in the plane, (3,) in space.
    """

    time: float
    fleet: FleetState
    joint: tuple[int, ...] = ()

    @property
    def angles(self) -> Array:
        """The joint angles q (N,) [rad], in space (N, 3); read-only."""
        return self._by_joint(self.fleet.chain[0, 0])

    @property
    def rates(self) -> Array:
        """The joint rates v (N,) [rad/s], in space (N, 3); read-only."""
        return self._by_joint(self.fleet.chain[1, 0])

    @property
    def effect_states(self) -> Array:
        """(states, N) what the effects in the arm remember, in the order of those effects, in space (states, N, 3); read-only."""
        return self._by_joint(self.fleet.chain[2:, 0])

    def _by_joint(self, rows: Array) -> Array:
        return rows.reshape(*rows.shape[:-1], -1, *self.joint) if self.joint else rows


class ArmSimulator:
    """One arm with its effects, step by step: exactly what :func:`hsr_pin.simulate` gives for the same commands and steps.

    ``state`` is all that changes. :meth:`advance` passes it explicitly instead; copies share nothing. The first use on a machine
    compiles for half a minute, once; ``dynamics="aba"`` starts at once and takes a hundred times as long for a step.

    Args:
        arm: the nominal arm.
        effects: what acts beside the nominal model, at most one of a kind.
        dynamics: "compiled", or "aba" or "rnea" over Pinocchio.
        integrator: a name from ``hsr_pin.simulation.integrator``.
        step: largest step of the integrator [s].
        markers: the points to follow; default: base, middle and tip.
        pressure_map: what pressures give, Eqs. (1), (4) and (5).
        torque_range: [N m] accepted commands; default: what holds a weightless arm within its bending limit. In
            space of their size, for each section.
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
        self._fleet = ArmFleet([arm], [self.effects], **self._options)  # type: ignore[arg-type]  # each as it is declared above
        self._joint: tuple[int, ...] = (3,) if arm.bending == "space" else ()
        self.state = self.reset()

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The points that :meth:`observe` follows."""
        return self._fleet.markers[0]

    def reset(self, torque: ArrayLike = 0.0, *, pose: Pose | None = None) -> ArmState:
        """Start anew at time 0.

        Args:
            torque: [N m] the command until now, in space (2,), of S sections (2 S,); without a pose the arm is settled under it.
            pose: angles and rates to start from instead.

        Raises:
            InputError: a torque out of range, or a pose of another number of joints.
            SimulationFailure: there is no equilibrium, or the arm is beyond its bending limit.
        """
        command = np.array([self._checked_torque(torque)])
        if pose is None:
            fleet, found = self._fleet.settled(command)
            if not found[0]:
                bent = self._bent(ArmState(0.0, fleet, self._joint))
                raise SimulationFailure(failed(0.0, bent, Outcome.NO_EQUILIBRIUM), ArmState(0.0, fleet, self._joint))
        else:
            if pose.angles.shape != (self.arm.links, *self._joint):
                expected = f"{self.arm.links} joint angles{' (towards x, towards y, twist)' * bool(self._joint)}"
                raise InputError("start", expected=expected, received=f"shape {pose.angles.shape}")
            assert pose.rates is not None
            fleet = self._fleet.placed(pose.angles.reshape(1, -1), pose.rates.reshape(1, -1), command)
        started = ArmState(0.0, fleet, self._joint)
        if not abs(self._fleet.columns.bends(fleet.chain[0, 0]).sum()) <= self._fleet.limit[0]:
            raise SimulationFailure(failed(0.0, self._bent(started)), started)
        self.state = started
        return started

    def step(self, torque: ArrayLike | None = None, *, pressures: ArrayLike | None = None, dt: float = STEP) -> ArmState:
        """Hold a command for ``dt`` [s]: a ``torque`` [N m], or ``pressures`` (2,) [bar] at the arm's stiffness.

        In space a torque has two components for each section, (2 S,) or (S, 2), and pressures give none.

        Raises:
            InputError: a command that is no number or out of range, none or two of them, or a step that is none.
            PressureError: pressures that are no numbers or out of range.
            SimulationFailure: the arm left its bending limit or diverged; its ``result``, and ``state``, are as before the step.
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
        """The state after a torque [N m], as for :meth:`step`, was held for ``dt`` [s] from any state; the simulator's own stays.

        Raises:
            InputError, SimulationFailure: as :meth:`step`.
        """
        command = np.array([self._checked_torque(torque)])
        fleet, lost = self._fleet.advance(state.fleet, command, _checked_time("dt", dt))
        if lost:
            raise SimulationFailure(failed(state.time, self._bent(ArmState(state.time, fleet, self._joint))), state)
        return ArmState(state.time + dt, fleet, self._joint)

    def observe(self, state: ArmState | None = None) -> Array:
        """(M, 3) [m] where the markers are seen in the world frame, with what the effects make of it; without noise."""
        return np.asarray(self._fleet.observe((state or self.state).fleet)[0])

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are built anew from what was asked for, with workspaces of their own, and take the state along."""
        options = {**self._options, "pressure_map": self.pressure_map, "torque_range": self.torque_range}
        return _rebuilt, (type(self), self.arm, self.effects, options, self.state)

    @staticmethod
    def _bent(state: ArmState) -> Array:
        """(N,) [rad] of the joints, in space by how much."""
        return np.asarray(np.linalg.norm(state.angles, axis=1)) if state.joint else state.angles

    def _checked_torque(self, torque: ArrayLike) -> Any:
        """A number; in space complex, of S > 1 sections (S,)."""
        low, high = self.torque_range
        if self._joint:
            return self._checked_vector(torque, high)
        try:
            value = float(torque)  # type: ignore[arg-type]  # what is none is refused
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


def _rebuilt(
    kind: type[ArmSimulator], arm: ArmSpecification, effects: tuple[Effect, ...], options: dict[str, Any], state: ArmState
) -> ArmSimulator:
    simulator = kind(arm, effects, **options)
    simulator.state = state
    return simulator
