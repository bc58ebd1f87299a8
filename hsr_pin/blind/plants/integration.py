"""Time loop around an engine: it settles, then records, with all laws applied.

Laws are evaluated at the start of each step of about 0.1 ms and held constant over it. The engine itself integrates linear
springs and dampers, including damping that a law adds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from hsr_pin.errors import SimulationFailure

from .arm import Arm, Array, Motion
from .laws.law import Joints, Law, Nodes, State, acting
from .program import RATE, Trial

SETTLE_BLOCK, LONGEST_SETTLING = 0.25, 10.0  # s
SETTLED = 1e-5  # m/s; an arm with a slower tip is at rest
STRETCH_TOLERANCE = 0.02  # of the length, because the rod stretches a little; an arm that stretches further has diverged
FULL_TURN = 2 * np.pi  # rad of bending from base to tip; an arm that bends further would pass through itself


AnyMotion = TypeVar("AnyMotion")


class Engine(Protocol):
    """One arm in one engine, at one instant; in space, bending, rates and moments are complex, x + i y, and vectors (3,).

    Attributes:
        places: (N,) arc lengths of the nodes [m].
    """

    places: Array

    def read(self) -> tuple[Array, Array]:
        """Return bending (n,) [rad] and its rate (n,) [rad/s] of the joints, each multiplied by n."""

    def nodes(self) -> Any:
        """Return the backbone as `Nodes`, or in space as `SpaceNodes`."""

    def advance(self, moment: Array, viscous: Array | None, force: Array | None, gravity: Array) -> None:
        """Simulate one step under moments (n,) [N m] and forces on nodes (2, N) [N]; gravity (2,) [m/s2]."""


def profile(laws: Sequence[Law], place: str, s: Array) -> Array:
    """Return the product of the laws' factors on ``stiffness``, ``damping`` or ``torque`` at s, (n,)."""
    out = np.ones_like(s)
    for law in acting(laws, place):
        out = out * getattr(law, place)(s)
    return out


def simulated(
    make: Callable[[Any, Array, Array, float], Engine],
    arm: Arm,
    trial: Trial,
    laws: Sequence[Law],
    scales: tuple[float, float],
    s: Array,
    step: float,
    motion: Callable[[Array, Array, Sequence[Any]], AnyMotion],
) -> AnyMotion:
    """Return the motion of an arm in a trial.

    Args:
        make: function that returns an engine for an arm, stiffness and damping (n,) of the whole arm [Nm/rad, Nm s/rad], and a
            step [s].
        arm: the true arm.
        trial: the trial.
        laws: physics that the model lacks.
        scales: true stiffness and damping relative to the declared ones.
        s: (n,) arc lengths of the joints, relative to the length.
        step: integrator step [s].
        motion: as for `Integration`.
    """
    stiffness = scales[0] * trial.keq * profile(laws, "stiffness", s)
    damping = scales[1] * trial.damping * profile(laws, "damping", s)
    engine = make(arm, stiffness, damping, step)
    integration = Integration(engine, Joints(s, trial.keq, stiffness, trial.damping), arm, trial, laws, step, motion)
    return integration.run(engine.places)


def applied_torque(laws: Sequence[Law], trial: Trial, dt: float) -> tuple[Any, Array]:
    """Return the torque at rest [N m], and that of each step (K,) [N m], after all laws between command and arm."""
    per_sample = round(1 / RATE / dt)
    tau = trial.torque()
    tau = np.repeat(np.concatenate([tau[:1], tau[:-1]]), per_sample)
    t = np.arange(-per_sample, tau.size - per_sample, dtype=float) * dt
    for law in acting(laws, "command"):
        tau = law.command(tau, t, trial.keq, trial.clock)
    return tau[0].item(), tau[per_sample:]


def planar(t: Array, s: Array, nodes: Sequence[Nodes]) -> Motion:
    """Return the motion from the nodes at each sample."""
    x, z = np.stack([each.position for each in nodes], axis=1)
    return Motion(t, s, x, z, np.stack([each.angle for each in nodes]))


class Integration(Generic[AnyMotion]):
    """Integration of one trial on an engine.

    Args:
        engine: engine at rest in its straight pose.
        joints: properties of the joints.
        arm: the true arm.
        trial: the trial.
        laws: physics that the model lacks.
        dt: integrator step [s].
        motion: function that returns the motion for times (T,), arc lengths (N,) and the nodes at each sample.
    """

    def __init__(
        self,
        engine: Engine,
        joints: Joints,
        arm: Arm,
        trial: Trial,
        laws: Sequence[Law],
        dt: float,
        motion: Callable[[Array, Array, Sequence[Any]], AnyMotion],
    ) -> None:
        self.engine, self.joints, self.trial, self.dt = engine, joints, trial, dt
        self._motion = motion
        self.gravity = arm.gravity()
        self.share = profile(laws, "torque", joints.s)
        self.tau_rest, self.tau = applied_torque(laws, trial, dt)
        self.moments = acting(laws, "moment")
        self.viscous = acting(laws, "viscous")
        self.forces = acting(laws, "force")
        self.states = [law.memory(joints) for law in self.moments]
        fine = np.arange(-1, self.tau.size + 2, dtype=float) * dt
        base = sum((law.base(fine) for law in acting(laws, "base")), np.zeros_like(fine))
        self.base_acceleration = np.diff(base, 2) / dt**2  # m/s2, acceleration of the base along x

    def run(self, s: Array) -> AnyMotion:
        """Return the motion at nodes with arc lengths s (N,) [m], at each sample of the trial."""
        self._settle()
        per_sample = round(1 / RATE / self.dt)
        frames, bent = [self.engine.nodes()], [self._total_bending()]
        for k in range(self.tau.size):
            self._step(k * self.dt, self.tau[k].item(), float(self.base_acceleration[k]))
            if (k + 1) % per_sample == 0:
                frames.append(self.engine.nodes())
                bent.append(self._total_bending())
        t = np.arange(len(frames)) / RATE
        motion = self._motion(t, s, frames)
        away = reduce(np.hypot, np.stack([frame.position for frame in frames], axis=1))
        sane = away <= s + STRETCH_TOLERANCE * s[-1]  # also False for NaN
        if not sane.all():
            first = float(t[np.argmin(sane.all(axis=1))])
            raise SimulationFailure(f"the plant diverged before t = {first:.2f} s", motion)
        if (round_ := np.asarray(bent) > FULL_TURN).any():
            first = float(t[np.argmax(round_)])
            raise SimulationFailure(f"the plant bends by more than a turn at t = {first:.2f} s, which no arm can", motion)
        return motion

    def _total_bending(self) -> float:
        """Return the bending from base to tip [rad]."""
        return float(abs(np.mean(self.engine.read()[0])))

    def _settle(self) -> None:
        steps = round(SETTLE_BLOCK / self.dt)
        for _ in range(round(LONGEST_SETTLING / SETTLE_BLOCK)):
            for _ in range(steps):
                self._step(-self.dt, self.tau_rest, 0.0, rest=True)
            if reduce(np.hypot, self.engine.nodes().velocity[:, -1]) < SETTLED:
                break

    def _step(self, t: float, tau: Any, base_acceleration: float, rest: bool = False) -> None:
        applied = tau * self.share
        held = 1.0 if rest else self._hold_factor(t)
        if held and self.trial.hold_torque:
            applied = applied + held * self.trial.hold_torque
        viscous: Array | None = None
        force: Array | None = None
        if self.moments or self.viscous or self.forces:
            state = State(*self.engine.read(), t, self.dt, self.trial.clock, tau, rest)
            for k, law in enumerate(self.moments):
                extra, self.states[k] = law.moment(self.joints, state, self.states[k])
                applied = applied - extra
            for law in self.viscous:
                more = law.viscous(self.joints, state)
                viscous = more if viscous is None else viscous + more
            if self.forces:
                nodes = self.engine.nodes()
                force = np.sum([law.force(state, nodes) for law in self.forces], axis=0)
        if held and self.trial.hold_force:
            force = np.zeros_like(self.engine.nodes().position) if force is None else force
            where = self.trial.hold_at * (force.shape[1] - 1)
            k = min(int(where), force.shape[1] - 2)
            pull = held * self.trial.hold_force * np.array([k + 1 - where, where - k])
            force[0, k : k + 2] += pull.real
            force[1, k : k + 2] += pull.imag
        gravity = self.gravity if base_acceleration == 0.0 else self.gravity - base_acceleration * np.eye(1, self.gravity.size)[0]
        self.engine.advance(applied, viscous, force, gravity)

    def _hold_factor(self, t: float) -> float:
        """Return the share of the holding loads that still acts, 1 to 0."""
        since = t - self.trial.release + self.dt / 2
        if since < 0 or not self.trial.release_duration:
            return float(since < 0)
        return max(0.0, 1 - since / self.trial.release_duration)
