"""A fine chain of hinges in MuJoCo (E. Todorov, T. Erez, Y. Tassa, MuJoCo, IROS 2012).

Each of the n hinges is in the middle of its element, so that the shape under a uniform moment converges to the arc with second
order in 1/n. MuJoCo's own springs, dampers and implicitfast integrator (implicit in the dampers) are used.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from hsr_pin.errors import MissingDependencyError

from .arm import Arm, Array
from .laws.law import Nodes
from .plant import Plant


def middles(n: int) -> Array:
    """Return the middles of n elements, (n,), relative to the length of the arm."""
    return np.asarray((np.arange(n) + 0.5) / n)


class MujocoEngine(ABC):
    """An engine in MuJoCo that implements `integration.Engine`.

    Args:
        arm: arm with all attached masses.
        stiffness: (n,) stiffness of the whole arm at each joint [Nm/rad].
        damping: (n,) damping of the whole arm at each joint [Nm s/rad].
        step: integrator step [s].
    """

    #: Degrees of freedom of a joint.
    joint_dofs: ClassVar[int]

    def __init__(self, arm: Arm, stiffness: Array, damping: Array, step: float) -> None:
        try:
            import mujoco
        except ImportError as error:
            raise MissingDependencyError("mujoco", "blind") from error
        self._mujoco = mujoco
        self.n = stiffness.size
        self.h = arm.length / self.n
        self.places = np.linspace(0.0, arm.length, self.n + 1)
        self.damping = np.repeat(self.n * damping, self.joint_dofs)
        self.model = build(arm, stiffness, damping, step, ball=self.joint_dofs == 3)
        self.data = mujoco.MjData(self.model)
        self._nodes: Any = None  # cache for the current instant

    @abstractmethod
    def read(self) -> tuple[Array, Array]:
        """Return bending and its rate, see `integration.Engine`."""

    @abstractmethod
    def nodes(self) -> Any:
        """Return the middles of the bodies, which are the ends of the elements; node 0 is the base."""

    @abstractmethod
    def apply(self, moment: Array, force: Array | None) -> None:
        """Apply moments (n,) [N m] and forces on nodes [N] to the bodies until the next call."""

    def advance(self, moment: Array, viscous: Array | None, force: Array | None, gravity: Array) -> None:
        """Simulate one step, see `integration.Engine`."""
        self.model.opt.gravity[:] = gravity if gravity.size == 3 else (gravity[0], 0.0, gravity[1])
        if viscous is not None:
            self.model.dof_damping[:] = self.damping + np.repeat(self.n * viscous, self.joint_dofs)
        self.apply(moment, force)
        self._mujoco.mj_step(self.model, self.data)
        self._nodes = None


class Chain(MujocoEngine):
    """Engine with hinges, for planar bending."""

    joint_dofs = 1

    def read(self) -> tuple[Array, Array]:
        return self.n * self.data.qpos, self.n * self.data.qvel

    def nodes(self) -> Nodes:
        if self._nodes is None:
            angle, rate = np.zeros(self.n + 1), np.zeros(self.n + 1)
            np.cumsum(self.data.qpos, out=angle[1:])
            np.cumsum(self.data.qvel, out=rate[1:])
            s, c = np.sin(angle), np.cos(angle)
            ways = np.array([s, c, rate * c, -rate * s])  # directions of the links, and their rates
            nodes = np.zeros_like(ways)
            np.cumsum((ways[:, :-1] + ways[:, 1:]) * (self.h / 2), axis=1, out=nodes[:, 1:])  # half a link of each neighbour
            self._nodes = Nodes(nodes[:2], nodes[2:], angle)
        return self._nodes  # type: ignore[no-any-return]

    def apply(self, moment: Array, force: Array | None) -> None:
        self.data.qfrc_applied[:] = moment if force is None else moment + self._torque(force)

    def _torque(self, force: Array) -> Array:
        """Return the joint torques (n,) [N m] of forces on the nodes (2, n + 1) [N]."""
        nodes = self.nodes()
        joint = nodes.position[:, :-1] + self.h / 2 * np.stack([np.sin(nodes.angle[:-1]), np.cos(nodes.angle[:-1])])
        beyond = np.cumsum(force[:, :0:-1], axis=1)[:, ::-1]
        (x, z), (fx, fz) = nodes.position, force
        turning = np.cumsum((fx * z - fz * x)[:0:-1])[::-1]
        torque: Array = turning - beyond[0] * joint[1] + beyond[1] * joint[0]
        return torque


@dataclass(frozen=True)
class ChainPlant(Plant):
    """The arm as a MuJoCo chain of hinges."""

    elements: int = 32
    step: float = 1e-4
    engine = Chain

    @property
    def joints(self) -> Array:
        return middles(self.elements)


def build(arm: Arm, stiffness: Array, damping: Array, step: float, *, ball: bool = False) -> Any:
    """Return the ``mujoco.MjModel`` of an arm along z that bends about y, or with ball joints about every axis.

    Spring and damper of joint i are n times ``stiffness[i]`` and ``damping[i]`` of the whole arm
    [Nm/rad, Nm s/rad].
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0.0, 0.0, 0.0]
    n, h, r = stiffness.size, arm.length / stiffness.size, arm.radius
    body, bodies = spec.worldbody, []
    for i in range(n):
        length = h if i < n - 1 else h / 2
        body = body.add_body(pos=[0, 0, h / 2 if i == 0 else h])
        kind = mujoco.mjtJoint.mjJNT_BALL if ball else mujoco.mjtJoint.mjJNT_HINGE
        joint = body.add_joint(type=kind, axis=[0, 1, 0])
        joint.stiffness = linear(joint.stiffness, n * stiffness[i])
        joint.damping = linear(joint.damping, n * damping[i])
        body.explicitinertial = True
        body.mass = arm.line_mass * length
        body.ipos = [0, 0, length / 2]
        across = body.mass * (3 * r * r + length * length) / 12
        body.inertia = [across, across, body.mass * r * r / 2]
        if arm.wall is not None:
            _collide(body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=[0, 0, length]), r, 1, 0)
        bodies.append(body)
    for place, mass in [*arm.lumps, (arm.length, arm.tip_mass)]:
        if mass > 0 and place >= h / 2:  # a mass nearer to the base does not move; joint i is at (i + 1/2) h
            i = min(int(place / h - 0.5), n - 1)
            lump = bodies[i].add_body(pos=[0, 0, place - (i + 0.5) * h])
            lump.explicitinertial = True
            lump.mass, lump.ipos, lump.inertia = mass, [0.0] * 3, [1e-12] * 3  # else MuJoCo uses the parent's
    if arm.wall is not None:
        wall = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, pos=[arm.wall, 0, 0])
        wall.quat = [np.sqrt(0.5), 0, -np.sqrt(0.5), 0]  # its normal points along -x
        _collide(wall, 1.0, 0, 1)
    return spec.compile()


def linear(field: Any, value: float) -> Any:
    """Return a spring or damper coefficient in the format of a field: MuJoCo 4 has polynomials, earlier versions one number."""
    return value if np.ndim(field) == 0 else [value, *[0.0] * (len(field) - 1)]


def _collide(geom: Any, size: float, contype: int, conaffinity: int) -> None:
    geom.size = [size, size, size]
    geom.contype, geom.conaffinity = contype, conaffinity
    geom.friction = [0.3, 0.005, 0.0001]
    geom.solref = [0.004, 1.0]
