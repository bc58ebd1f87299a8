"""A fine chain of ball joints in MuJoCo (E. Todorov, T. Erez, Y. Tassa, MuJoCo, IROS 2012).

A ball in the middle of each element, with MuJoCo's own spring and damper: the same about all axes, so that the arm is as stiff
against twisting as against bending. Moments of laws act in the axes of the outer link.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from hsr_pin.errors import MissingDependencyError

from ..arm import Array
from ..chain import linear
from ..laws.law import Joints, Law
from ..march import March, profile
from ..plant import Plant
from ..program import Trial
from ..writing import Marker
from .arm import SpaceArm, SpaceMotion
from .writing import SpaceMarker, observe


@dataclass(frozen=True)
class BallPlant(Plant):
    """The arm as a MuJoCo chain in space.

    Attributes:
        elements: number of balls. step: integrator step [s], a whole fraction of 10 ms.
        bare: the arm as declared.
    """

    elements: int = 24
    step: float = 2e-4
    bare: SpaceArm = field(default_factory=SpaceArm)

    def simulate(self, trial: Trial, laws: Sequence[Law] = (), k: float = 1.0, c: float = 1.0) -> SpaceMotion:  # type: ignore[override]
        """The motion in a trial; true stiffness and damping are k and c times the declared ones."""
        arm = replace(self.bare, tip_mass=self.bare.tip_mass + trial.tip_mass)
        for law in laws:
            arm = law.arm(arm, trial)  # type: ignore[assignment]  # of the same kind
        s = (np.arange(self.elements) + 0.5) / self.elements
        stiffness = k * trial.keq * profile(laws, "stiffness", s)
        damping = c * trial.damping * profile(laws, "damping", s)
        engine = Balls(arm, stiffness, damping, self.step)
        march = March(engine, Joints(s, trial.keq, stiffness, trial.damping), arm, trial, laws, self.step, motion)  # type: ignore[arg-type]
        return march.run(np.linspace(0.0, arm.length, self.elements + 1))

    def observed(self, motion: Any, arm: Any, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
        """As in the plane, of markers that may stand beside the backbone."""
        return observe(motion, arm, laws, [SpaceMarker.of(marker) for marker in markers], error)


class SpaceNodes(NamedTuple):
    """Points along the backbone: position (3, N) [m], velocity of the last (3, 1) [m/s], axes (N, 3, 3); no angles."""

    position: Array
    velocity: Array
    frames: Array
    angle: Array


def motion(t: Array, s: Array, nodes: Sequence[Any]) -> SpaceMotion:
    """Of the nodes at each sample."""
    return SpaceMotion(t, s, np.stack([each.position for each in nodes]), np.stack([each.frames for each in nodes]))


class Balls:
    """The engine: see `march.Engine`; bending, rates and moments are complex, x + i y.

    Args:
        arm: with everything on it. stiffness, damping: (n,) of the whole arm [Nm/rad, Nm s/rad].
        step: [s].
    """

    def __init__(self, arm: SpaceArm, stiffness: Array, damping: Array, step: float) -> None:
        try:
            import mujoco
        except ImportError as error:
            raise MissingDependencyError("mujoco", "blind") from error
        self._mujoco = mujoco
        self.n = stiffness.size
        self.h = arm.length / self.n
        self.damping = np.repeat(self.n * damping, 3)
        self.model = build(arm, stiffness, damping, step)
        self.data = mujoco.MjData(self.model)
        self._nodes: SpaceNodes | None = None  # of the present instant, once asked for

    def read(self) -> tuple[Array, Array]:
        """See `march.Engine`."""
        quaternion, rate = self.data.qpos.reshape(-1, 4), self.data.qvel.reshape(-1, 3)
        size = np.linalg.norm(quaternion[:, 1:], axis=1)
        angle = 2 * np.arctan2(size, quaternion[:, 0])
        turn = quaternion[:, 1:] * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 2.0)[:, None]
        return tuple(self.n * (each[:, 1] - 1j * each[:, 0]) for each in (turn, rate))

    def nodes(self) -> SpaceNodes:
        """The middles of the bodies, which are the elements' ends: node 0 is the base."""
        if self._nodes is None:
            self._mujoco.mj_kinematics(self.model, self.data)
            self._mujoco.mj_comPos(self.model, self.data)
            self._mujoco.mj_comVel(self.model, self.data)
            frames = np.concatenate([np.eye(3)[None], self.data.xmat[1 : self.n + 1].reshape(-1, 3, 3)])
            middles = self.data.xpos[1 : self.n + 1] + self.h / 2 * frames[1:, :, 2]
            found = np.zeros(6)
            self._mujoco.mj_objectVelocity(self.model, self.data, self._mujoco.mjtObj.mjOBJ_XBODY, self.n, found, 0)
            tip = found[3:] + np.cross(found[:3], self.h / 2 * frames[-1, :, 2])
            position = np.concatenate([np.zeros((1, 3)), middles]).T
            self._nodes = SpaceNodes(position, tip[:, None], frames, np.zeros(self.n + 1))
        return self._nodes

    def advance(self, moment: Array, viscous: Array | None, force: Array | None, gravity: Array) -> None:
        """See `march.Engine`; forces (3, N) [N]."""
        self.model.opt.gravity[:] = gravity
        if viscous is not None:
            self.model.dof_damping[:] = self.damping + np.repeat(self.n * viscous, 3)
        self.data.qfrc_applied.reshape(-1, 3)[:, 0] = -np.imag(moment)
        self.data.qfrc_applied.reshape(-1, 3)[:, 1] = np.real(moment)
        self.data.xfrc_applied[:] = 0.0
        if force is not None:
            places = self.nodes().position[:, 1:].T
            arms = places - self.data.xipos[1 : self.n + 1]
            self.data.xfrc_applied[1 : self.n + 1] = np.hstack([force[:, 1:].T, np.cross(arms, force[:, 1:].T)])
        self._mujoco.mj_step(self.model, self.data)
        self._nodes = None


def build(arm: SpaceArm, stiffness: Array, damping: Array, step: float) -> Any:
    """The ``mujoco.MjModel`` of an arm along z.

    Spring and damper of joint i are n times ``stiffness[i]`` and ``damping[i]`` of the whole arm
    [Nm/rad, Nm s/rad], about every axis.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    n, h, r = stiffness.size, arm.length / stiffness.size, arm.radius
    body, bodies = spec.worldbody, []
    for i in range(n):
        length = h if i < n - 1 else h / 2
        body = body.add_body(pos=[0, 0, h / 2 if i == 0 else h])
        joint = body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
        joint.stiffness = linear(joint.stiffness, n * stiffness[i])
        joint.damping = linear(joint.damping, n * damping[i])
        body.explicitinertial = True
        body.mass = arm.line_mass * length
        body.ipos = [0, 0, length / 2]
        across = body.mass * (3 * r * r + length * length) / 12
        body.inertia = [across, across, body.mass * r * r / 2]
        bodies.append(body)
    for place, mass in [*arm.lumps, (arm.length, arm.tip_mass)]:
        if mass > 0 and place >= h / 2:  # what is nearer to the base does not move
            i = min(int(place / h - 0.5), n - 1)
            lump = bodies[i].add_body(pos=[0, 0, place - (i + 0.5) * h])
            lump.explicitinertial = True
            lump.mass, lump.ipos, lump.inertia = mass, [0.0] * 3, [1e-12] * 3
    return spec.compile()
