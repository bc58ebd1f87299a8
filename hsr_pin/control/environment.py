"""The arm as Gymnasium environments that reach a tip target or follow a tip path; they require the dependency group ``gym``.

M. Towers et al., Gymnasium: a standard interface for reinforcement learning environments, arXiv:2407.17032 (2024)::

    from hsr_pin.control.registration import register

    register()
    env = gymnasium.make("hsr_pin/ReachTip-v0")
    env = gymnasium.make("hsr_pin/FollowTip-v0", arm=ArmSpecification(keq=2.33), effects=[parse_effect("tip_mass:mass=0.02")])
    envs = gymnasium.make_vec("hsr_pin/ReachTip-v0", num_envs=1000)  # see hsr_pin.control.vector

======================  ===========  =========================================================================================
action (1,)             1            torque on every joint over ``largest_torque``, from -1 to 1
observation 0, 1        m            tip x and z, in the world frame
observation 2, 3        m/s          their rates, clipped at +-``FASTEST``
observation 4           rad          bending angle of the whole arm
observation 5           rad/s        its rate, clipped at +-``FASTEST_BENDING``
observation 6, 7        m            target x and z now
observation 8, 9        m            target x and z ``AHEAD`` seconds later (reach: the same)
reward                  1            minus the tip's distance from the target over the arm's length, in every step
======================  ===========  =========================================================================================

An arm in space (``ArmSpecification(bending="space")``) takes an action (2,), towards x and towards y of its base, and every
position has a y component too:

======================  ===========  =========================================================================================
action (2,)             1            torques on every joint over ``largest_torque``, each from -1 to 1
observation 0 to 2      m            tip x, y and z, in the world frame
observation 3 to 5      m/s          their rates, clipped at +-``FASTEST``
observation 6, 7        rad          bending of the whole arm towards x and towards y
observation 8, 9        rad/s        its rates, clipped at +-``FASTEST_BENDING``
observation 10 to 12    m            target x, y and z now
observation 13 to 15    m            target x, y and z ``AHEAD`` seconds later (reach: the same)
======================  ===========  =========================================================================================

Marker positions include the effects on the measurement, without noise. An episode is truncated after ``duration`` seconds. It
terminates earlier if the arm exceeds its bending limit, with the worst reward, -2, for every remaining step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hsr_pin.control.task import Episodes, Follow, Reach, TipTask
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, MissingDependencyError
from hsr_pin.robot.specification import ArmSpecification

try:
    import gymnasium
    from gymnasium import spaces
except ImportError as error:
    raise MissingDependencyError("gymnasium", "gym") from error

_Observation = NDArray[np.float64]


class TipEnvironment(gymnasium.Env[_Observation, _Observation]):
    """Base class of both environments.

    Args:
        arm: the arm; targets are equilibrium positions of its tip.
        effects: effects in addition to the nominal model.
        largest_torque: torque of an action of 1 [N m]; default: the torque that bends the arm by one radian.
        dt: duration of an action [s].
        duration: duration of an episode [s].
        integrator: a name from ``hsr_pin.simulation.integrator``.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  # Gymnasium's own form
    kind: ClassVar[type[TipTask]]

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
        self.task = self.kind(
            [self.arm], [effects], largest_torque=largest_torque, dt=dt, duration=duration, integrator=integrator
        )
        self.action_space = spaces.Box(-1.0, 1.0, (self.task.inputs,), np.float64)
        self.observation_space = spaces.Box(-self.task.highest[0], self.task.highest[0], dtype=np.float64)
        self._at: Episodes | None = None

    @property
    def steps(self) -> int:
        """Number of steps of an episode."""
        return self.task.steps

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Observation, dict[str, Any]]:
        """Put the arm in equilibrium without torque and draw a new target.

        Args:
            seed: seed of the targets.
            options: "torque" [N m] of the initial equilibrium; "target" (2,) x and z to reach [m], or "path" (steps + 1, 2) to
                follow [m]; in space "torque" (2,), "target" (3,) and "path" (steps + 1, 3).

        Raises:
            InputError: an option is unknown, or its value is invalid.
        """
        super().reset(seed=seed)
        chosen = dict(options or {})
        torque, one = chosen.pop("torque", 0.0), np.zeros(1, dtype=int)
        targets = self.task.targets([self.np_random], one, chosen)
        if chosen:
            raise InputError("reset options", expected="torque, and target or path", received=", ".join(chosen))
        self._at = self.task.episodes(self.task.settled(torque), one, targets)
        return self.task.observations(self._at)[0], self._facts(self._at)

    def step(self, action: Any) -> tuple[_Observation, float, bool, bool, dict[str, Any]]:
        """Hold a torque (1,), in space (2,), as a share of ``largest_torque``, for ``dt``.

        Raises:
            InputError: the action has another shape, is not a number or is out of range; or the environment was not reset.
        """
        if self._at is None:
            raise InputError("step", expected="a reset before the first", received="none")
        share, inputs = np.asarray(action, dtype=float), self.task.inputs
        if share.shape != (inputs,) or not np.all(np.abs(share) <= 1):
            many = "one number" if inputs == 1 else "two numbers"
            raise InputError("action", expected=f"{many} from -1 to 1, shape ({inputs},)", received=share)
        done = self.task.step(self._at, self.task.shares(share[None]))
        self._at = done.episodes
        facts = self._facts(self._at) | ({"failure": done.failures[0]} if done.failures else {})
        seen = self.task.observations(self._at)[0]
        return seen, float(done.rewards[0]), bool(done.terminated[0]), bool(done.truncated[0]), facts

    def _facts(self, at: Episodes) -> dict[str, Any]:
        """Return the ``distance`` [m] of the tip from the target and the ``time`` [s]."""
        return {"distance": float(at.distance[0]), "time": float(at.count[0] * self.task.dt)}


class ReachTip(TipEnvironment):
    """Bring the tip to an equilibrium position, and hold it there."""

    kind = Reach


class FollowTip(TipEnvironment):
    """Follow a target that moves along equilibrium positions of the tip: three sines of up to 1 Hz, starting at rest."""

    kind = Follow
