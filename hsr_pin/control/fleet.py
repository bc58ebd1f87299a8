"""Arms to step side by side: commands in, states out, all in one call of the compiled loop."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns, likeness
from hsr_pin.simulation.integrator import STEP, Integrator
from hsr_pin.simulation.motion import Dynamics, Engine
from hsr_pin.simulation.muscles import Muscles, Past
from hsr_pin.simulation.result import Outcome, furthest_joint, reason_of
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array, Marker


class FleetState(NamedTuple):
    """All there is to know of B arms between two steps.

    Attributes:
        chain: (2 + states, B, N) joint angles [rad], rates [rad/s], and what the laws in the joints remember; read-only. In
            space (2 + states, B, 3 N), memories as vectors.
        muscles: what the muscles remember.
        first: (B, N) [rad], in space (B, 3 N), the angles at the start, as the cameras first saw them.
    """

    chain: Array
    muscles: tuple[Past, ...]
    first: Array


class ArmFleet:
    """B arms with effects of the same kinds, exactly as each would be alone. Keeps no state: it is passed in and handed back.

    Args:
        arms: (B,) with the same number of links, placement and mount; their numbers may differ.
        effects: (B,) of each arm, of the same types and options; their numbers may differ.
        dynamics: "compiled", or "aba" or "rnea" over Pinocchio.
        integrator: a name from ``hsr_pin.simulation.integrator``.
        step: largest step of the integrator [s].
        markers: the points to follow on all; default: base, middle and tip of each.

    Attributes:
        columns: the arms as the simulation takes them.
        limit: (B,) [rad] largest bending angle of each arm.
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
        if len({likeness(scenario) for scenario in scenarios}) != 1:
            raise InputError("arms", expected="the same links, placement, mount and kinds of effects", received="others")
        self.columns = columns = Columns.of(scenarios)
        every = np.repeat(np.arange(len(columns)), self._sections)  # each section has muscles of its own
        self._engine, self._muscles = Engine(columns, dynamics), Muscles(columns.members(every), step)
        self.limit = columns.arms.bending_limit
        self.markers = [scenario.markers for scenario in scenarios]
        self._cameras = Cameras(columns, [s.reach for s in scenarios], [s.beside for s in scenarios])

    def settled(self, torque: Array) -> tuple[FleetState, NDArray[np.bool_]]:
        """At rest under constant commands (B,) [N m], and whether there is such a pose (B,).

        In space commands are complex, here and below; of arms of S > 1 sections (B, S).
        """
        arrives, muscles = self._muscles.rested(torque.ravel())
        straight = np.zeros((len(torque), self.columns.coordinates))
        q, found = self._engine.settled(arrives.reshape(torque.shape), np.ones(len(torque), dtype=bool), straight)
        return self._loaded(q, np.zeros_like(q), muscles), found

    def placed(self, q: Array, v: Array, torque: Array) -> FleetState:
        """At angles and rates (B, N) [rad], [rad/s], where the commands (B,) [N m] were constant until now."""
        return self._loaded(q, v, self._muscles.rested(torque.ravel())[1])

    def advance(self, state: FleetState, torque: Array, dt: float) -> tuple[FleetState, int]:
        """Hold commands (B,) [N m] for ``dt`` [s].

        Returns:
            The state then, and how many arms left their bending limits; see :meth:`lost`.
        """
        impulse, cell, muscles = self._muscles.hold(torque if torque.ndim == 1 else torque.ravel(), dt, state.muscles)
        if self._sections > 1:
            impulse = impulse.reshape(*torque.shape, -1).swapaxes(1, 2)
        chain = state.chain.copy()
        lost = self._engine.advance(chain, impulse, cell, self._weights)
        chain.setflags(write=False)
        return FleetState(chain, muscles, state.first), lost

    def lost(self, state: FleetState) -> NDArray[np.bool_]:
        """(B,) which arms left their bending limits in the step to a state; their angles are those at the end of it."""
        return np.asarray(np.isnan(state.chain[1, :, 0]))

    def observe(self, state: FleetState) -> Array:
        """(B, M, 3) [m] where the markers are seen in the world frame, with what the effects make of it; without noise."""
        seen: Array = self._cameras.positions(np.stack([state.first, state.chain[0]]))[1]
        return seen

    def renewed(self, chosen: NDArray[np.bool_], fresh: FleetState, state: FleetState) -> FleetState:
        """The state where the ``chosen`` (B,) arms are as in another, which has just begun."""
        chain = np.where(chosen[:, None], fresh.chain, state.chain)
        chain.flags.writeable = False
        muscles = self._muscles.renewed(np.repeat(chosen, self._sections), fresh.muscles, state.muscles)
        return FleetState(chain, muscles, np.where(chosen[:, None], fresh.first, state.first))

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are built anew: machine code has another address elsewhere."""
        return self._made, ()

    def _loaded(self, q: Array, v: Array, muscles: tuple[Past, ...]) -> FleetState:
        state = self._engine.loaded(q, v)
        chain = np.concatenate([state.q[None], state.v[None], self.columns.rows(state.z)])
        chain.flags.writeable = False
        return FleetState(chain, muscles, chain[0])


def failed(time: float, q: Array, outcome: Outcome | None = None) -> str:
    """Why the step from a time [s] could not be done, in which an arm came to joint angles q (N,) [rad]."""
    where = f"in the step from t = {time:.4g} s, joint {furthest_joint(q)}"
    return f"simulation stopped {where}: {(outcome or reason_of(q)).value}"
