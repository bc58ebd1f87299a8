"""The arm as Gymnasium environments: reach a tip target, follow a tip path. Needs the group ``gym``.

M. Towers et al., Gymnasium: a standard interface for reinforcement learning environments, arXiv:2407.17032 (2024)::

    from hsr_pin.control.registration import register

    register()
    env = gymnasium.make("hsr_pin/ReachTip-v0")
    env = gymnasium.make("hsr_pin/FollowTip-v0", arm=ArmSpecification(keq=2.33), effects=[parse_effect("tip_mass:mass=0.02")])

======================  ===========  =========================================================================================
action (1,)             1            torque on every joint over ``largest_torque``, from -1 to 1
observation 0, 1        m            tip x and z, in the world frame
observation 2, 3        m/s          their rates, cut at +-``FASTEST``
observation 4           rad          bending angle of the whole arm
observation 5           rad/s        its rate, cut at +-``FASTEST_BENDING``
observation 6, 7        m            target x and z now
observation 8, 9        m            target x and z ``AHEAD`` seconds later (reach: the same)
reward                  1            minus the tip's distance from the target over the arm's length, in every step
======================  ===========  =========================================================================================

Markers are seen with what the effects make of them, without noise. An episode is cut off after ``duration`` seconds. It ends
sooner where the arm leaves its bending limit, at the price of the worst reward, -2, for every step that was left.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reach import rest_at_tip, static_pose
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, MissingDependencyError, SimulationFailure
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

try:
    import gymnasium
    from gymnasium import spaces
except ImportError as error:
    raise MissingDependencyError("gymnasium", "gym") from error

#: Bounds of observed rates: [m/s] and [rad/s].
FASTEST, FASTEST_BENDING = 20.0, 200.0
#: How far an observation looks ahead along the path [s].
AHEAD = 0.1

_Observation = NDArray[np.float64]


class TipEnvironment(gymnasium.Env[_Observation, _Observation]):
    """What both tasks share.

    Args:
        arm: the arm; targets are places where its tip can rest.
        effects: what acts beside the nominal model.
        largest_torque: what an action of 1 gives [N m]; default: what bends the arm by one radian.
        dt: [s] that an action is held.
        duration: of an episode [s].
        integrator: a name from ``hsr_pin.simulation.integrators``.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  # Gymnasium's own form

    def __init__(
        self,
        arm: ArmSpecification | None = None,
        effects: Sequence[Effect] = (),
        *,
        largest_torque: float | None = None,
        dt: float = 0.02,
        duration: float = 3.0,
        integrator: str = "extrapolated4",
    ) -> None:
        self.arm = arm or ArmSpecification()
        self.largest_torque = self.arm.keq if largest_torque is None else float(largest_torque)
        if not (0 < self.largest_torque < np.inf and 0 < dt <= duration < np.inf):
            raise InputError(
                "environment",
                expected="largest_torque and dt above zero, duration at least dt",
                received=f"{largest_torque}, {dt}, {duration}",
            )
        self.dt, self.steps = dt, round(duration / dt)
        bound = self.largest_torque
        self.simulator = ArmSimulator(self.arm, effects, integrator=integrator, torque_range=(-bound, bound))
        self.dynamics = ArmDynamics(self.arm)
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float64)
        place, bend = [1.5 * self.arm.length] * 2, self.arm.bending_limit
        high = np.array([*place, FASTEST, FASTEST, bend, FASTEST_BENDING, *place, *place])
        self.observation_space = spaces.Box(-high, high, dtype=np.float64)
        self._count, self._targets = 0, np.zeros((self.steps + 1, 2))

    @abstractmethod
    def path(self, options: dict[str, Any]) -> Array:
        """(steps + 1, 2) [m] x and z of the target at every step; drawn with ``np_random`` where ``options`` name none."""

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Observation, dict[str, Any]]:
        """Settle the arm under no torque and draw a new target.

        Args:
            seed: of the targets.
            options: "torque" [N m] to settle under; "target" (2,) [m] x and z to reach, or "path" (steps + 1, 2) [m] to follow.

        Raises:
            InputError: an unknown option, or a value that cannot be used.
        """
        super().reset(seed=seed)
        chosen = dict(options or {})
        torque = chosen.pop("torque", 0.0)
        self._targets, self._count = self.path(chosen), 0
        if chosen:
            raise InputError("reset options", expected="torque, and target or path", received=", ".join(chosen))
        self.simulator.reset(torque)
        return self._observation(), self._facts()

    def step(self, action: Any) -> tuple[_Observation, float, bool, bool, dict[str, Any]]:
        """Hold a torque (1,), as a share of ``largest_torque``, for ``dt``.

        Raises:
            InputError: an action of another shape, not a number, or out of range.
        """
        share = np.asarray(action, dtype=float)
        if share.shape != (1,) or not abs(share[0]) <= 1:
            raise InputError("action", expected="one number from -1 to 1, shape (1,)", received=share)
        left = self.steps - self._count
        self._count = min(self._count + 1, self.steps)
        try:
            self.simulator.step(share[0] * self.largest_torque, dt=self.dt)
        except SimulationFailure as failure:
            return self._observation(), -2.0 * left, True, False, self._facts() | {"failure": str(failure)}
        facts = self._facts()
        return self._observation(), -facts["distance"] / self.arm.length, False, self._count >= self.steps, facts

    def _observation(self) -> _Observation:
        state = self.simulator.state
        rate = self.dynamics.tip_jacobian(state.angles)[[0, 2]] @ state.rates
        ahead = min(self._count + round(AHEAD / self.dt), self.steps)
        seen = [self._tip(), rate, [state.angles.sum(), state.rates.sum()], self._targets[self._count], self._targets[ahead]]
        space = self.observation_space
        assert isinstance(space, spaces.Box)
        return np.asarray(np.clip(np.concatenate(seen), space.low, space.high))

    def _tip(self) -> Array:
        return np.asarray(self.simulator.observe()[-1, [0, 2]])

    def _facts(self) -> dict[str, Any]:
        """``distance`` [m] of the tip from the target, ``time`` [s]."""
        distance = float(np.linalg.norm(self._tip() - self._targets[self._count]))
        return {"distance": distance, "time": self._count * self.dt}

    def _rest_tips(self, torques: Array) -> Array:
        return np.asarray(self.dynamics.tip(static_pose(self.dynamics, torques))[:, [0, 2]])


class ReachTip(TipEnvironment):
    """Bring the tip to a place where it can rest, and hold it there."""

    def path(self, options: dict[str, Any]) -> Array:
        """One target: ``options["target"]`` (2,) [m], or the nearest place to it where the tip can rest."""
        bound = self.largest_torque
        if "target" in options:
            target = rest_at_tip(self.dynamics, options.pop("target"), (-bound, bound)).tip[[0, 2]]
        else:
            target = self._rest_tips(self.np_random.uniform(-0.9 * bound, 0.9 * bound, 1))[0]
        return np.tile(target, (self.steps + 1, 1))


class FollowTip(TipEnvironment):
    """Follow a target that wanders along the places where the tip can rest: three sines of up to 1 Hz, from rest."""

    def path(self, options: dict[str, Any]) -> Array:
        """``options["path"]`` (steps + 1, 2) [m] as it is, or a drawn one."""
        if "path" in options:
            path = np.asarray(options.pop("path"), dtype=float)
            if path.shape != (self.steps + 1, 2) or not np.isfinite(path).all():
                raise InputError(
                    "path", expected=f"finite x and z [m], shape ({self.steps + 1}, 2)", received=f"shape {path.shape}"
                )
            return path
        time = np.arange(self.steps + 1)[:, None] * self.dt
        frequency, share = self.np_random.uniform(0.2, 1.0, 3), self.np_random.uniform(-1.0, 1.0, 3)
        wave = np.sin(2 * np.pi * frequency * time) @ share / 3
        return self._rest_tips(0.9 * self.largest_torque * wave)
