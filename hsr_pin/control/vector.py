"""Many arms as one vector environment of Gymnasium, advanced in one call of the compiled loop; requires the group ``gym``.

::

    from hsr_pin.control.registration import register

    register()
    envs = gymnasium.make_vec("hsr_pin/ReachTip-v0", num_envs=1000)
    envs = gymnasium.make_vec("hsr_pin/ReachTip-v0", num_envs=2, arm=[ArmSpecification(mass=0.15), ArmSpecification(mass=0.2)])

Each arm behaves like its single environment (:mod:`hsr_pin.control.environment`), to rounding. Seeds and infos are those of
Gymnasium's ``SyncVectorEnv``; autoreset is "next step": an arm whose episode has ended is reset by the next step, whatever its
action.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hsr_pin.control.fleet import FleetState
from hsr_pin.control.task import Episodes, Follow, Reach, TipTask
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, MissingDependencyError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

try:
    from gymnasium import spaces
    from gymnasium.utils import seeding
    from gymnasium.vector import AutoresetMode, VectorEnv
except ImportError as error:
    raise MissingDependencyError("gymnasium", "gym") from error

_Flags = NDArray[np.bool_]


class TipVector(VectorEnv[Array, Array, NDArray[Any]]):
    """Base class of both vector environments.

    Args:
        num_envs: number of arms.
        arm: the same arm for all, or one for each with the same links, placement, mount and bending.
        effects: the same effects for all, or a sequence for each with the same types and options.
        largest_torque: torque of an action of 1, for all or for each [N m]; default: the torque that bends an arm by one radian.
        dt: duration of an action [s].
        duration: duration of an episode [s].
        integrator: a name from ``hsr_pin.simulation.integrator``.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012  # Gymnasium's own form
    kind: ClassVar[type[TipTask]]

    def __init__(
        self,
        num_envs: int = 1,
        arm: ArmSpecification | Sequence[ArmSpecification] | None = None,
        effects: Sequence[Effect] | Sequence[Sequence[Effect]] = (),
        *,
        largest_torque: ArrayLike | None = None,
        dt: float = 0.02,
        duration: float = 3.0,
        integrator: str = "extrapolated4",
    ) -> None:
        arms = [arm or ArmSpecification()] * num_envs if isinstance(arm, ArmSpecification | None) else list(arm)
        shared = all(isinstance(effect, Effect) for effect in effects)
        own: list[Any] = [tuple(effects)] * num_envs if shared else list(effects)
        if num_envs < 1 or not len(arms) == len(own) == num_envs:
            received = f"{len(arms)} arms, {len(own)} sequences of effects"
            raise InputError(
                "environment", expected=f"one for all, or one for each of {num_envs} environments", received=received
            )
        self.num_envs = num_envs
        self.task = self.kind(arms, own, largest_torque=largest_torque, dt=dt, duration=duration, integrator=integrator)
        highest = self.task.highest
        self.single_action_space = spaces.Box(-1.0, 1.0, (self.task.inputs,), np.float64)
        self.action_space = spaces.Box(-1.0, 1.0, (num_envs, self.task.inputs), np.float64)
        self.single_observation_space = spaces.Box(-highest[0], highest[0], dtype=np.float64)
        self.observation_space = spaces.Box(-highest, highest, dtype=np.float64)
        self._random: list[np.random.Generator | None] = [None] * num_envs
        self._ended, self._hanging = np.zeros(num_envs, dtype=bool), self.task.settled(0.0)
        targets = np.zeros((num_envs, self.task.steps + 1, 3 if self.task.space else 2))
        self._at, self._begun = self.task.episodes(self._hanging, np.zeros(num_envs, dtype=int), targets), False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Put the arms in equilibrium without torque and draw new targets.

        Args:
            seed: seeds of the targets: one for each, or the first of consecutive numbers.
            options: as for the single environment, the same for all; "reset_mask" (num_envs,): the arms to reset.

        Raises:
            InputError: an option is unknown, or its value is invalid.
        """
        if isinstance(seed, int):
            seed = range(seed, seed + self.num_envs)
        seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise InputError("seed", expected=f"a number, or {self.num_envs} of them", received=f"{len(seeds)}")
        chosen = dict(options or {})
        mask = np.asarray(chosen.pop("reset_mask", np.ones(self.num_envs, dtype=bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise InputError("reset_mask", expected=f"{self.num_envs} truth values, one true at least", received=mask)
        torque = chosen.pop("torque", 0.0)
        for i in np.flatnonzero(mask).tolist():
            if seeds[i] is not None:
                self._random[i] = seeding.np_random(seeds[i])[0]
        self._at = self._renewed(mask, self._hanging if not np.any(torque) else self.task.settled(torque), chosen)
        self._ended, self._begun = self._ended & ~mask, True
        return self.task.observations(self._at), self._facts(mask)

    def step(self, actions: Array) -> tuple[Array, Array, _Flags, _Flags, dict[str, Any]]:
        """Hold torques (num_envs, 1), as shares of ``largest_torque``, for ``dt``, and reset the arms whose episodes have ended.

        In space the torques are (num_envs, 2).

        Raises:
            InputError: the actions have another shape, are not numbers or are out of range; or the environments were not reset.
        """
        if not self._begun:
            raise InputError("step", expected="a reset before the first", received="none")
        again, shares = self._ended, np.asarray(actions, dtype=float)
        if shares.shape != self.action_space.shape or not np.all((np.abs(shares) <= 1).all(axis=1) | again):
            expected = f"numbers from -1 to 1, shape {self.action_space.shape}"
            raise InputError("actions", expected=expected, received=f"shape {shares.shape}, {shares.ravel()}")
        done = self.task.step(self._at, np.where(again, 0.0, self.task.shares(shares)))
        self._at = done.episodes
        if again.any():
            self._at = self._renewed(again, self._hanging, {})
        terminated, truncated = done.terminated & ~again, done.truncated & ~again
        self._ended = terminated | truncated
        facts = self._facts(np.ones(self.num_envs, dtype=bool))
        for i in np.flatnonzero(terminated).tolist():
            facts = self._add_info(facts, {"failure": done.failures[i]}, i)
        return self.task.observations(self._at), np.where(again, 0.0, done.rewards), terminated, truncated, facts

    @property  # type: ignore[misc]  # as Gymnasium's SyncVectorEnv has it
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """Random generators of the arms (num_envs,)."""
        return tuple(self._generator(i) for i in range(self.num_envs))

    def _generator(self, place: int) -> np.random.Generator:
        found = self._random[place] or seeding.np_random()[0]
        self._random[place] = found
        return found

    def _renewed(self, mask: _Flags, fresh: FleetState, options: dict[str, Any]) -> Episodes:
        """Return the episodes after those in the mask have begun anew; raise an error for unknown options."""
        members, at = np.flatnonzero(mask), self._at
        targets = at.targets.copy()
        targets[mask] = self.task.targets([self._generator(i) for i in members.tolist()], members, options)
        if options:
            raise InputError("reset options", expected="torque, and target or path", received=", ".join(options))
        return self.task.episodes(self.task.fleet.renewed(mask, fresh, at.fleet), np.where(mask, 0, at.count), targets)

    def _facts(self, mask: _Flags) -> dict[str, Any]:
        """Return the infos of the single environment, with the masks that Gymnasium requires."""
        distance, time = self._at.distance, self._at.count * self.task.dt
        facts = {"distance": np.where(mask, distance, 0.0), "time": np.where(mask, time, 0.0)}
        return facts | {f"_{name}": mask.copy() for name in facts}


class ReachTips(TipVector):
    """Bring each tip to an equilibrium position, and hold it there."""

    kind = Reach


class FollowTips(TipVector):
    """Follow targets that move along equilibrium positions of the tips: three sines of up to 1 Hz, starting at rest."""

    kind = Follow
