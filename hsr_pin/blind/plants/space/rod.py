"""A Cosserat rod in space in PyElastica, with the same dampers and the same shear stiffness as the planar one in `rod`.

Like the chain of ball joints, the rod has equal stiffness and damping in torsion and in bending. The dampers are solved
separately for each axis of space. For this, the inertia of a slice about its own axis equals that about the axes across it, which
is half of a disc's. The difference is a two-hundredth of the inertia against swinging of the arm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..arm import Arm, Array
from ..rod import Cosserat, RodPlant, joints_of
from .arm import SpaceNodes
from .plant import SpacePlant


class SpaceRod(Cosserat):
    """Engine of a rod that bends about its first two directors, x and y; bending, rates and moments are complex, x + i y."""

    normal = (1.0, 0.0, 0.0)

    def __init__(self, arm: Arm, stiffness: Array, damping: Array, step: float) -> None:
        super().__init__(arm, stiffness, damping, step)
        for inertia in (self.rod.mass_second_moment_of_inertia, self.rod.inv_mass_second_moment_of_inertia):
            inertia[2, 2] = inertia[0, 0]

    def read(self) -> tuple[Array, Array]:
        turn, between = self._joints()
        omega = self.rod.omega_collection
        rate = omega[:, 1:] - np.einsum("jin,jn->in", between, omega[:, :-1])
        return tuple(self.per_bend * (each[1] - 1j * each[0]) for each in (turn, rate))

    def nodes(self) -> SpaceNodes:
        turn, _ = self._joints()
        frames = np.moveaxis(self.rod.director_collection, (0, 1, 2), (2, 1, 0))  # (n + 1, 3, 3), axes as columns
        halves = Rotation.from_rotvec(turn.T / 2).as_matrix()
        frames = np.concatenate([np.eye(3)[None], frames[:-1] @ halves, frames[-1:] @ halves[-1:]])
        position = np.concatenate([np.zeros((3, 1)), self.rod.position_collection[:, 1:]], axis=1)
        return SpaceNodes(position, self.rod.velocity_collection[:, -1:].copy(), frames, np.zeros(len(frames)))

    def apply_loads(self, rod: Any) -> None:
        rod.external_forces += rod.mass * self.gravity[:, None]
        if self.force is not None:
            rod.external_forces[:, 1:] += self.force[:, 1:]
        moment = np.zeros((3, len(self.moment)))
        moment[0], moment[1] = -np.imag(self.moment), np.real(self.moment)
        rod.external_torques[:, 1:] += moment  # in the axes of the outer element of each joint
        _, between = self._joints()
        rod.external_torques[:, 1:-1] -= np.einsum("ijn,jn->in", between, moment)[:, 1:]

    def apply_dampers(self, rod: Any) -> None:
        rate, axes = rod.omega_collection, rod.director_collection
        rate[:, 0] = 0.0
        in_space = np.einsum("ijn,in->nj", axes[..., 1:], rate[:, 1:])
        rate[:, 1:] = np.einsum("ijn,nj->in", axes[..., 1:], self.damped(in_space))

    def _joints(self) -> tuple[Array, Array]:
        """Return the joints' rotation vectors (3, n) [rad], and the rotations (3, 3, n) from outer to inner element axes."""
        axes = self.rod.director_collection
        between = np.einsum("ikn,jkn->ijn", axes[..., :-1], axes[..., 1:])
        size = np.array([between[2, 1] - between[1, 2], between[0, 2] - between[2, 0], between[1, 0] - between[0, 1]]) / 2
        sine = np.sqrt((size**2).sum(axis=0))
        angle = np.arctan2(sine, (np.trace(between) - 1) / 2)
        return size * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-12), 1.0), between


@dataclass(frozen=True)
class SpaceRodPlant(SpacePlant):
    """The arm as a PyElastica rod in space."""

    elements: int = 16
    step: float = 1e-4
    engine = SpaceRod
    refinement = RodPlant.refinement

    @property
    def joints(self) -> Array:
        return joints_of(self.elements)
