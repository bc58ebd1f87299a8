"""Many arms that are advanced in one call of the compiled loop: commands in, states out."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.actuators import ActuatorMemory, Actuators
from hsr_pin.simulation.arm_batch import ArmBatch, batch_key
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.integrator import STEP, Integrator
from hsr_pin.simulation.motion import Dynamics, Engine
from hsr_pin.simulation.result import Outcome, furthest_joint, reason_of
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array, Marker


class FleetState(NamedTuple):
    """The complete state of B arms between two steps.

    Attributes:
        chain: (2 + states, B, N) joint angles [rad], rates [rad/s], and states of the laws in the joints; read-only. The states
            of arms in space are vectors: (2 + states, B, 3 N).
        actuators: memories of the actuators.
        first: (B, N) initial angles, in space (B, 3 N), which the effects on the measurement may refer to [rad].
    """

    chain: Array
    actuators: tuple[ActuatorMemory, ...]
    first: Array


class ArmFleet:
    """B arms with effects of the same kinds, with the same results as separate arms; it keeps no state.

    The state is an argument and a result of each call.

    Args:
        arms: (B,) arms with the same number of links, placement and mount; their numbers may differ.
        effects: (B,) effects of each arm, of the same types and options; their numbers may differ.
        dynamics: "compiled", or "aba" or "rnea" with Pinocchio.
        integrator: a name from ``hsr_pin.simulation.integrator``.
        step: largest step of the integrator [s].
        markers: points to follow on all arms; default: base, middle and tip of each.

    Attributes:
        batch: the arms as a batch.
        limit: (B,) largest bending angle of each arm [rad].
        markers: (B,) the points that :meth:`observe` follows on each arm.
    """

    def __init__(
        self,
        arms: Sequence[ArmSpecification],
        effects: Sequence[Sequence[Effect]],
        *,
        dynamics: Dynamics = "compiled",
        integrator: str = "extrapolated4",
        step: float = STEP,
        markers: tuple[Marker, ...] = (),
    ) -> None:
        self._made = partial(ArmFleet, arms, effects, dynamics=dynamics, integrator=integrator, step=step, markers=markers)
        self._weights = Integrator(integrator, step=step).weights
        made = zip(arms, effects, strict=True)
        time = np.array([0.0, 1.0])
        self._sections = max(1, len(arms[0].sections))
        still = np.zeros((2, 2 * self._sections) if arms[0].bending == "space" else 2)
        scenarios = [Scenario(arm, time, still, effects=tuple(own), markers=markers) for arm, own in made]
        if len({batch_key(scenario) for scenario in scenarios}) != 1:
            raise InputError("arms", expected="the same links, placement, mount and kinds of effects", received="others")
        self.batch = batch = ArmBatch.of(scenarios)
        every = np.repeat(np.arange(len(batch)), self._sections)  # each section has separate actuators
        self._engine, self._actuators = Engine(batch, dynamics), Actuators(batch.members(every), step)
        self.limit = batch.arms.bending_limit
        self.markers = [scenario.markers for scenario in scenarios]
        self._cameras = Cameras(batch, [s.reach for s in scenarios], [s.beside for s in scenarios])

    def settled(self, torque: Array) -> tuple[FleetState, NDArray[np.bool_]]:
        """Return the equilibrium state under constant commands (B,) [N m], and whether there is one (B,).

        In space, commands are complex, here and below; for arms of S > 1 sections (B, S).
        """
        arrives, actuators = self._actuators.settled(torque.ravel())
        straight = np.zeros((len(torque), self.batch.coordinates))
        q, found = self._engine.settled(arrives.reshape(torque.shape), np.ones(len(torque), dtype=bool), straight)
        return self._loaded(q, np.zeros_like(q), actuators), found

    def placed(self, q: Array, v: Array, torque: Array) -> FleetState:
        """Return the state at angles and rates (B, N) [rad], [rad/s], with constant commands (B,) [N m] until now."""
        return self._loaded(q, v, self._actuators.settled(torque.ravel())[1])

    def advance(self, state: FleetState, torque: Array, dt: float) -> tuple[FleetState, int]:
        """Hold commands (B,) [N m] for ``dt`` [s].

        Returns:
            The new state, and the number of arms that exceeded their bending limits; see :meth:`lost`.
        """
        impulse, cell, actuators = self._actuators.hold(torque if torque.ndim == 1 else torque.ravel(), dt, state.actuators)
        if self._sections > 1:
            impulse = impulse.reshape(*torque.shape, -1).swapaxes(1, 2)
        chain = state.chain.copy()
        lost = self._engine.advance(chain, impulse, cell, self._weights)
        chain.setflags(write=False)
        return FleetState(chain, actuators, state.first), lost

    def lost(self, state: FleetState) -> NDArray[np.bool_]:
        """Return which arms (B,) exceeded their bending limits in the step to a state; their angles are those at its end."""
        return np.asarray(np.isnan(state.chain[1, :, 0]))

    def observe(self, state: FleetState) -> Array:
        """Return the measured marker positions (B, M, 3) [m] in the world frame, with measurement effects but without noise."""
        seen: Array = self._cameras.positions(np.stack([state.first, state.chain[0]]))[1]
        return seen

    def renewed(self, chosen: NDArray[np.bool_], fresh: FleetState, state: FleetState) -> FleetState:
        """Return the state in which the ``chosen`` (B,) arms have the state ``fresh`` of new episodes."""
        chain = np.where(chosen[:, None], fresh.chain, state.chain)
        chain.flags.writeable = False
        actuators = self._actuators.renewed(np.repeat(chosen, self._sections), fresh.actuators, state.actuators)
        return FleetState(chain, actuators, np.where(chosen[:, None], fresh.first, state.first))

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are built anew, because the addresses of machine code differ between processes."""
        return self._made, ()

    def _loaded(self, q: Array, v: Array, actuators: tuple[ActuatorMemory, ...]) -> FleetState:
        state = self._engine.loaded(q, v)
        chain = np.concatenate([state.q[None], state.v[None], self.batch.rows(state.z)])
        chain.flags.writeable = False
        return FleetState(chain, actuators, chain[0])


def failure_message(time: float, q: Array, outcome: Outcome | None = None) -> str:
    """Return the reason why a step from a time [s] failed, in which an arm reached joint angles q (N,) [rad]."""
    where = f"in the step from t = {time:.4g} s, joint {furthest_joint(q)}"
    return f"simulation stopped {where}: {(outcome or reason_of(q)).value}"
