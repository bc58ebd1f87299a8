"""A fine chain of ball joints in MuJoCo (E. Todorov, T. Erez, Y. Tassa, MuJoCo, IROS 2012).

Each element has a ball joint in its middle, with MuJoCo's own spring and damper. They are equal about all axes, so torsional and
bending stiffness are equal. Moments of laws act in the axes of the outer link.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arm import Array
from ..chain import MujocoEngine, middles
from .arm import SpaceNodes
from .plant import SpacePlant


class Balls(MujocoEngine):
    """Engine with ball joints; bending, rates and moments are complex, x + i y."""

    joint_dofs = 3

    def read(self) -> tuple[Array, Array]:
        quaternion, rate = self.data.qpos.reshape(-1, 4), self.data.qvel.reshape(-1, 3)
        size = np.linalg.norm(quaternion[:, 1:], axis=1)
        angle = 2 * np.arctan2(size, quaternion[:, 0])
        turn = quaternion[:, 1:] * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 2.0)[:, None]
        return tuple(self.n * (each[:, 1] - 1j * each[:, 0]) for each in (turn, rate))

    def nodes(self) -> SpaceNodes:
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
        return self._nodes  # type: ignore[no-any-return]

    def apply(self, moment: Array, force: Array | None) -> None:
        self.data.qfrc_applied.reshape(-1, 3)[:, 0] = -np.imag(moment)
        self.data.qfrc_applied.reshape(-1, 3)[:, 1] = np.real(moment)
        self.data.xfrc_applied[:] = 0.0
        if force is not None:
            places = self.nodes().position[:, 1:].T
            arms = places - self.data.xipos[1 : self.n + 1]
            self.data.xfrc_applied[1 : self.n + 1] = np.hstack([force[:, 1:].T, np.cross(arms, force[:, 1:].T)])


@dataclass(frozen=True)
class BallPlant(SpacePlant):
    """The arm as a MuJoCo chain of ball joints."""

    elements: int = 24
    step: float = 2e-4
    engine = Balls

    @property
    def joints(self) -> Array:
        return middles(self.elements)
