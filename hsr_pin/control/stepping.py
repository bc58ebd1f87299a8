"""An arm to step by hand, as a controller or a learner does: command in, state out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, PressureError, SimulationFailure
from hsr_pin.robot.pressure import PAPER, PressureMap
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import STEP
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns, shape_of
from hsr_pin.simulation.integrators import integrator as integrator_named
from hsr_pin.simulation.result import Outcome, furthest_joint, reason_of
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.stepper import ChainState, Stepper, starting_state
from hsr_pin.trajectory import Array, Marker

#: Shortest and longest step [s] that can be asked for.
SHORTEST, LONGEST = 1e-6, 60.0
#: Step lengths whose integrators are kept.
_KEPT = 8


@dataclass(frozen=True, eq=False, slots=True)
class ArmState:
    """All there is to know of an arm between two steps.

    Attributes:
        time: [s] since the reset.
        chain: the same for the integrator, with what the effects remember.
    """

    time: float
    chain: ChainState

    @property
    def angles(self) -> Array:
        """The joint angles q (N,) [rad], read-only."""
        return np.asarray(self.chain.q[:, 0])

    @property
    def rates(self) -> Array:
        """The joint rates v (N,) [rad/s], read-only."""
        return np.asarray(self.chain.v[:, 0])

    @property
    def effect_states(self) -> tuple[Array, ...]:
        """Internal states of the effects in the arm, (states, N) each, in the order of those effects."""
        return tuple(law[:, :, 0] for law in self.chain.laws)


class ArmSimulator:
    """One arm with its effects, step by step: exactly what :func:`hsr_pin.simulate` gives for the same commands.

    ``state`` is all that changes. :meth:`advance` passes it explicitly instead; copies share nothing.

    Args:
        arm: the nominal arm.
        effects: what acts beside the nominal model, at most one of a kind.
        dynamics: "aba" or "rnea".
        integrator: a name from ``hsr_pin.simulation.integrators``.
        step: largest step of the integrator [s].
        markers: the points to follow; default: base, middle and tip.
        pressure_map: what pressures give, Eqs. (1), (4) and (5).
        torque_range: [N m] accepted commands; default: what holds a weightless arm within its bending limit.
    """

    def __init__(
        self,
        arm: ArmSpecification,
        effects: Sequence[Effect] = (),
        *,
        dynamics: str = "aba",
        integrator: str = "extrapolated4",
        step: float = STEP,
        markers: tuple[Marker, ...] = (),
        pressure_map: PressureMap = PAPER,
        torque_range: tuple[float, float] | None = None,
    ) -> None:
        self.arm, self.effects, self.pressure_map = arm, tuple(effects), pressure_map
        self.torque_range = torque_range or (-arm.keq * arm.bending_limit, arm.keq * arm.bending_limit)
        self._dynamics, self._integrator, self._largest_step = dynamics, integrator, _checked_time("step", step)
        self._method = integrator_named(integrator)
        self._scenario = Scenario(arm, np.array([0.0, 1.0]), np.zeros(2), effects=self.effects, markers=markers)
        self._columns = self._columns_from(Settled())
        self._cameras = Cameras(self._columns.arm_models[0], self._scenario.markers, self._columns.effects)
        self._limit = self._columns.arms[0].bending_limit
        self._steppers: dict[float, tuple[Stepper, int]] = {}
        self.state = self.reset()

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The points that :meth:`observe` follows."""
        return self._scenario.markers

    def reset(self, torque: float = 0.0, *, pose: Pose | None = None) -> ArmState:
        """Start anew at time 0.

        Args:
            torque: [N m] the command until now; without a pose the arm is settled under it.
            pose: angles and rates to start from instead.

        Raises:
            InputError: a torque out of range, or a pose of another number of joints.
            SimulationFailure: there is no equilibrium, or the arm is beyond its bending limit.
        """
        torque = self._checked_torque(torque)
        columns = self._columns_from(pose or Settled(torque))
        chain, found = starting_state(columns, np.array([torque]))
        self.state = _frozen(0.0, chain)
        if not found[0]:
            raise self._failure(self.state, chain.q[:, 0], Outcome.NO_EQUILIBRIUM)
        if not abs(chain.q.sum()) <= self._limit:
            raise self._failure(self.state, chain.q[:, 0], reason_of(chain.q[:, 0]))
        return self.state

    def step(self, torque: float | None = None, *, pressures: ArrayLike | None = None, dt: float = STEP) -> ArmState:
        """Hold a command for ``dt`` [s]: a ``torque`` [N m], or ``pressures`` (2,) [bar] at the arm's stiffness.

        Raises:
            InputError: a command that is no number or out of range, none or two of them, or a step that is none.
            PressureError: pressures that are no numbers or out of range.
            SimulationFailure: the arm left its bending limit or diverged; its ``result``, and ``state``, are as before the step.
        """
        if (torque is None) == (pressures is None):
            received = "neither" if torque is None else "both"
            raise InputError("command", expected="a torque [N m] or pressures [bar]", received=received)
        if torque is None:
            delivered = self.pressure_map.torque(np.asarray(pressures), self.arm.keq)
            if delivered.ndim:
                raise PressureError(
                    "pressures", expected="one P1 and one P2 [bar]", received=f"shape {np.shape(delivered)} of each"
                )
            torque = float(delivered)
        self.state = self.advance(self.state, torque, dt)
        return self.state

    def advance(self, state: ArmState, torque: float, dt: float = STEP) -> ArmState:
        """The state after ``torque`` [N m] was held for ``dt`` [s], from any state; the simulator's own stays as it is.

        Raises:
            InputError, SimulationFailure: as :meth:`step`.
        """
        command = np.array([self._checked_torque(torque)])
        stepper, count = self._steppers.get(dt) or self._stepper(dt)
        chain, limit = state.chain, self._limit
        for _ in range(count):
            chain = stepper.advance(chain, command)
            if not abs(chain.q.sum()) <= limit:  # nan is beyond too
                raise self._failure(state, chain.q[:, 0], reason_of(chain.q[:, 0]))
        return _frozen(state.time + dt, chain)

    def observe(self, state: ArmState | None = None) -> Array:
        """(M, 3) [m] where the markers are seen in the world frame, with what the effects make of it; without noise."""
        chain = (state or self.state).chain
        return np.asarray(self._cameras.positions(chain.q.T[None])[0, 0])

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are built anew from what was asked for, with workspaces of their own, and take the state along."""
        options = {
            "dynamics": self._dynamics,
            "integrator": self._integrator,
            "step": self._largest_step,
            "markers": self.markers,
            "pressure_map": self.pressure_map,
            "torque_range": self.torque_range,
        }
        return _rebuilt, (type(self), self.arm, self.effects, options, self.state)

    def _columns_from(self, start: Settled | Pose) -> Columns:
        base = self._scenario
        scenario = Scenario(base.arm, base.time, base.torque, start, base.effects, base.markers, implicit_as=base)
        return Columns([scenario], shape_of(scenario, 1.0))

    def _stepper(self, dt: float) -> tuple[Stepper, int]:
        """The integrator for a step and how often it is called; built once for each length, by the rule of :func:`shape_of`."""
        whole = round(_checked_time("dt", dt), 12)
        count = max(1, math.ceil(whole / self._largest_step - 1e-6))
        if len(self._steppers) >= _KEPT:
            self._steppers.pop(next(iter(self._steppers)))
        self._steppers[dt] = made = Stepper(self._columns, self._method, whole / count, self._dynamics), count
        return made

    def _checked_torque(self, torque: float) -> float:
        low, high = self.torque_range
        try:
            value = float(torque)
        except (TypeError, ValueError):
            value = math.nan
        if not low <= value <= high:
            raise InputError("torque", expected=f"{low:.4g} to {high:.4g} N m", received=torque)
        return value

    @staticmethod
    def _failure(last: ArmState, q: Array, outcome: Outcome) -> SimulationFailure:
        where = f"in the step from t = {last.time:.4g} s, joint {furthest_joint(q)}"
        return SimulationFailure(f"simulation stopped {where}: {outcome.value}", last)


def _frozen(time: float, chain: ChainState) -> ArmState:
    chain.q.flags.writeable = chain.v.flags.writeable = False
    for law in chain.laws:
        law.flags.writeable = False
    return ArmState(time, chain)


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
