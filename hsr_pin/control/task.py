"""The tasks of the environments: tips that reach a target or follow a path, of one arm or of many arms in a batch.

They are the basis of :mod:`~hsr_pin.control.environment` and :mod:`~hsr_pin.control.vector`, which define the observations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.fleet import ArmFleet, FleetState, failure_message
from hsr_pin.control.reach import rest_at_tip, static_poses
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.robot.space_kinematics import SpaceMarkerMap, space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.trajectory import Array

#: Bounds of observed rates: [m/s] and [rad/s].
FASTEST, FASTEST_BENDING = 20.0, 200.0
#: Preview of the path in an observation [s].
AHEAD = 0.1


@dataclass(frozen=True, eq=False)
class Episodes:
    """The current state of the episodes of B arms.

    Attributes:
        fleet: state of the arms.
        count: (B,) steps since the last reset.
        targets: (B, steps + 1, D) target positions at every step: x and z, in space x, y and z [m].
        tips: (B, D) measured tip positions [m].
    """

    fleet: FleetState
    count: NDArray[np.int64]
    targets: Array
    tips: Array

    @property
    def target(self) -> Array:
        """Current target positions (B, D) [m]."""
        return self.targets[np.arange(len(self.count)), self.count]

    @property
    def distance(self) -> Array:
        """Distances (B,) of the tips from their targets [m]."""
        return np.asarray(np.linalg.norm(self.tips - self.target, axis=1))


@dataclass(frozen=True, eq=False)
class Stepped:
    """The result of a step of B arms.

    Attributes:
        episodes: the state after the step; an arm that failed keeps its previous state.
        rewards: (B,) rewards.
        terminated, truncated: (B,) whether the episodes have ended.
        failures: messages about the arms that failed.
    """

    episodes: Episodes
    rewards: Array
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    failures: dict[int, str]


class TipTask(ABC):
    """Base class of both tasks.

    Args:
        arms: (B,) the arms; targets are equilibrium positions of their tips.
        effects: (B,) effects of each arm in addition to the nominal model.
        largest_torque: torque of an action of 1, for all arms or for each [N m]; default: the torque that bends an arm by one
            radian.
        dt: duration of an action [s].
        duration: duration of an episode [s].
        integrator: a name from ``hsr_pin.simulation.integrator``.
    """

    def __init__(
        self,
        arms: Sequence[ArmSpecification],
        effects: Sequence[Sequence[Effect]],
        *,
        largest_torque: ArrayLike | None,
        dt: float,
        duration: float,
        integrator: str,
    ) -> None:
        if (parts := max((len(arm.sections) for arm in arms), default=0)) > 1:
            raise InputError("sections", expected="none, because the arm of an environment has one torque", received=parts)
        self.fleet = ArmFleet(arms, effects, integrator=integrator)
        self.arms, self.space = self.fleet.batch.nominal, self.fleet.batch.space
        self._axes = [0, 1, 2] if self.space else [0, 2]
        self.largest_torque = np.broadcast_to(self.arms.keq if largest_torque is None else largest_torque, len(arms)).astype(
            float
        )
        if not (np.all((self.largest_torque > 0) & (self.largest_torque < np.inf)) and 0 < dt <= duration < np.inf):
            raise InputError(
                "environment",
                expected="largest_torque and dt above zero, duration at least dt",
                received=f"{self.largest_torque}, {dt}, {duration}",
            )
        self.dt, self.steps = dt, round(duration / dt)
        self._nominal = ArmBatch(self.arms, ())
        self._tips = self._map(self.fleet.batch.arms)
        one, inputs = np.ones((len(arms), 1)), self.inputs
        place = np.tile(1.5 * self.arms.length[:, None], len(self._axes))
        bending = np.tile(self.arms.bending_limit[:, None], inputs), np.tile(FASTEST_BENDING * one, inputs)
        self.highest = np.hstack([place, np.tile(FASTEST * one, len(self._axes)), *bending, place, place])

    def __len__(self) -> int:
        return len(self.arms)

    @property
    def inputs(self) -> int:
        """Number of torques of an arm: one, in space two, towards x and towards y of the base."""
        return 2 if self.space else 1

    def _map(self, arms: Arms) -> MarkerMap | SpaceMarkerMap:
        """Return the marker map of the tips, without the effects on the measurement."""
        return space_marker_map(arms, arms.length[:, None]) if self.space else marker_map(arms, arms.length[:, None])

    def shares(self, actions: Array) -> Array:
        """Return actions (B, inputs) as numbers (B,), complex in space."""
        return np.asarray(actions[:, 0] + 1j * actions[:, 1] if self.space else actions[:, 0])

    @abstractmethod
    def targets(self, random: Sequence[np.random.Generator], members: NDArray[np.intp], options: dict[str, Any]) -> Array:
        """Return the target positions (K, steps + 1, D) [m] of K arms, drawn with separate generators or given by ``options``.

        The options that are used are removed from the dict.
        """

    def settled(self, torque: ArrayLike) -> FleetState:
        """Return the equilibrium of all arms under a torque [N m], in space (2,) or 0.

        Raises:
            InputError: the torque exceeds that of an action, or an arm has no equilibrium under it within its bending limit.
        """
        bound, parts = float(self.largest_torque.min()), np.atleast_1d(np.asarray(torque, dtype=float))
        parts = np.zeros(self.inputs) if not parts.any() else parts
        if parts.shape != (self.inputs,) or not np.all(np.abs(parts) <= bound):
            each = " towards x and towards y" if self.space else ""
            raise InputError("torque", expected=f"{-bound:.4g} to {bound:.4g} N m{each}", received=torque)
        state, found = self.fleet.settled(np.repeat(self.shares(parts[None]), len(self)))
        if not np.all(found & (np.abs(self._bent(state.chain[0])) <= self.fleet.limit)):
            raise InputError("torque", expected="one that the arm can rest under", received=torque)
        return state

    def _bent(self, rows: Array) -> Array:
        """Return the bending (B,) [rad] (or its rate) of whole arms from joint angles (or rates), complex in space."""
        return np.asarray(self.fleet.batch.bends(rows).sum(axis=1))

    def step(self, episodes: Episodes, shares: Array) -> Stepped:
        """Hold torques (B,), complex in space, as shares of ``largest_torque``, for ``dt``."""
        count = np.minimum(episodes.count + 1, self.steps)
        state, _ = self.fleet.advance(episodes.fleet, shares * self.largest_torque, self.dt)
        lost = self.fleet.lost(state)
        failures = {int(b): failure_message(episodes.count[b] * self.dt, state.chain[0, b]) for b in np.flatnonzero(lost)}
        if lost.all():
            state = episodes.fleet
        elif failures:
            state = state._replace(chain=np.where(lost[:, None], episodes.fleet.chain, state.chain))
        now = self.episodes(state, count, episodes.targets)
        rewards = np.where(lost, -2.0 * (self.steps - episodes.count), -now.distance / self.arms.length)
        return Stepped(now, rewards, lost, ~lost & (count >= self.steps), failures)

    def episodes(self, fleet: FleetState, count: NDArray[np.int64], targets: Array) -> Episodes:
        """Return the episodes of the arms in a given state."""
        return Episodes(fleet, count, targets, self.fleet.observe(fleet)[:, -1, self._axes])

    def observations(self, episodes: Episodes) -> Array:
        """Return the observations (B, 10), in space (B, 16)."""
        q, v = episodes.fleet.chain[:2]
        rates = self._tips.velocities(q, v)[:, 0, self._axes]
        bends = [self._bent(rows) for rows in (q, v)]
        bending = np.column_stack([part for bend in bends for part in ((bend.real, bend.imag) if self.space else (bend,))])
        ahead = np.minimum(episodes.count + round(AHEAD / self.dt), self.steps)
        later = episodes.targets[np.arange(len(self)), ahead]
        seen = np.hstack([episodes.tips, rates, bending, episodes.target, later])
        return np.asarray(np.clip(seen, -self.highest, self.highest))

    def rest_tips(self, members: NDArray[np.intp], shares: Array) -> Array:
        """Return the equilibrium tip positions (K, T, D) [m] of K arms under torques (K, T), as shares of ``largest_torque``."""
        arms = self._nominal.members(members)
        poses = static_poses(arms, (shares * self.largest_torque[members, None]).T)
        tips = self._map(arms.arms).positions(poses)
        return np.asarray(tips[:, :, 0, self._axes].swapaxes(0, 1))


class Reach(TipTask):
    """Bring the tip to an equilibrium position, and hold it there."""

    def targets(self, random: Sequence[np.random.Generator], members: NDArray[np.intp], options: dict[str, Any]) -> Array:
        """Return constant targets: the equilibrium tip position nearest to ``options["target"]`` (D,) [m], or a drawn one."""
        if "target" in options:
            point = options.pop("target")
            targets = np.array([self._nearest(int(b), point) for b in members])[:, None]
        else:
            targets = self.rest_tips(members, np.array([self._drawn(own) for own in random]))
        return np.repeat(targets, self.steps + 1, axis=1)

    def _nearest(self, member: int, point: ArrayLike) -> Array:
        bound = self.largest_torque[member]
        return rest_at_tip(ArmDynamics(self.arms.specification(member)), point, (-bound, bound)).tip[self._axes]

    def _drawn(self, random: np.random.Generator) -> Array:
        """Draw a share (1,) of the largest torque; in space uniformly over the disc of all directions."""
        if not self.space:
            return np.asarray(random.uniform(-0.9, 0.9, 1))
        size, side = 0.9 * np.sqrt(random.uniform()), random.uniform(-np.pi, np.pi)
        return np.array([size * np.exp(1j * side)])


class Follow(TipTask):
    """Follow a target that moves along equilibrium positions of the tip: three sines of up to 1 Hz, starting at rest."""

    def targets(self, random: Sequence[np.random.Generator], members: NDArray[np.intp], options: dict[str, Any]) -> Array:
        """Return ``options["path"]`` (steps + 1, D) [m], or drawn paths."""
        if "path" in options:
            path = np.asarray(options.pop("path"), dtype=float)
            shape = (self.steps + 1, len(self._axes))
            if path.shape != shape or not np.isfinite(path).all():
                named = "x, y and z" if self.space else "x and z"
                raise InputError("path", expected=f"finite {named} [m], shape {shape}", received=f"shape {path.shape}")
            return np.tile(path, (len(members), 1, 1))
        return self.rest_tips(members, 0.9 * np.array([self._drawn(own) for own in random]))

    def _drawn(self, random: np.random.Generator) -> Array:
        """Draw shares (steps + 1,) of the largest torque, with a magnitude of at most 1."""
        if not self.space:
            return self._wave(random)
        return np.asarray((self._wave(random) + 1j * self._wave(random)) / np.sqrt(2))

    def _wave(self, random: np.random.Generator) -> Array:
        time = np.arange(self.steps + 1)[:, None] * self.dt
        frequency, share = random.uniform(0.2, 1.0, 3), random.uniform(-1.0, 1.0, 3)
        return np.sin(2 * np.pi * frequency * time) @ share / 3
