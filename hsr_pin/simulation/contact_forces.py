"""The forces of obstacles on an arm, computed from its motion."""

from __future__ import annotations

from ctypes import CFUNCTYPE, c_double, c_int64, c_void_p
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.contact import COMPONENTS, POSES, START, compiled, poses_in_plane, poses_in_space
from hsr_pin.simulation.kernel import ADDED
from hsr_pin.trajectory import Array, Trajectory

if TYPE_CHECKING:
    from hsr_pin.simulation.scenario import Scenario


@dataclass(frozen=True, eq=False)
class ContactForces:
    """The forces of O obstacles on an arm of N links, in the world frame.

    Attributes:
        by_link: (T, O, N, 3) force on each link [N].
        places: (T, O, N, 3) points of the backbone at which these forces act [m].
    """

    by_link: Array
    places: Array

    @property
    def force(self) -> Array:
        """Force of each obstacle (T, O, 3) [N]."""
        return np.asarray(self.by_link.sum(axis=2))

    @property
    def point(self) -> Array:
        """Point of the backbone (T, O, 3) at which each force acts on average [m]; NaN without contact."""
        size = np.linalg.norm(self.by_link, axis=3, keepdims=True)
        with np.errstate(invalid="ignore"):
            return np.asarray((size * self.places).sum(axis=2) / size.sum(axis=2))


def contact_forces(scenario: Scenario, motion: Trajectory) -> ContactForces:
    """Return the forces of the obstacles in a simulated motion.

    Friction follows from the displacements between the samples, which must be dense enough to show where a surface turns back.

    Raises:
        InputError: the motion has no joint angles, as one that was recorded.
    """
    if motion.joint_angles is None or motion.joint_rates is None:
        raise InputError("contact forces", expected="a simulated motion", received="a motion without joint angles")
    batch = ArmBatch.of([scenario])
    world, points, links = np.ascontiguousarray(batch.world[0]), int(batch.touch[3]), batch.links
    press, slide = (
        CFUNCTYPE(None, *[c_void_p] * 6, *[c_int64] * 5, *more)(function.address)
        for function, more in zip(compiled(batch.space), ([c_double], []), strict=True)
    )
    q = np.ascontiguousarray(motion.joint_angles.reshape(len(motion.joint_angles), -1))
    v = np.ascontiguousarray(motion.joint_rates.reshape(q.shape))
    reach = np.ascontiguousarray(batch.arrays.reach[0])
    old, new = np.zeros((2, points * COMPONENTS, links), dtype=complex if batch.space else float)
    found = np.zeros((len(q), len(world), ADDED, links))
    for t in range(len(q)):
        if t and len(world):
            slide(*(part.ctypes.data for part in (old, q[t - 1], q[t], reach, world, new)), 1, 0, links, len(world), points)
            old[:] = new
        for o in range(len(world)):
            body = np.ascontiguousarray(world[o])
            press(*(part.ctypes.data for part in (q[t], v[t], new, reach, body, found[t, o])), 1, 0, links, 1, points, 0.0)
    g, poses = np.empty((POSES, links)), poses_in_space if batch.space else poses_in_plane
    placed = np.empty((len(q), 1, links, 6))
    for t in range(len(q)):
        poses(q[t], v[t], world[0, START] if len(world) else 0.0, reach, g)
        placed[t, 0] = g[:6].T
    joint, along = placed[..., :3], placed[..., 3:]
    force, moment = -found[:, :, 24:27].swapaxes(2, 3), -found[:, :, 21:24].swapaxes(2, 3)
    lever = np.cross(along, force)  # the moment about the joint for each metre along the link
    square = (lever**2).sum(axis=3, keepdims=True)
    way = np.divide((lever * moment).sum(axis=3, keepdims=True), square, out=np.zeros_like(square), where=square > 0)
    places = joint + np.clip(way, 0.0, reach[:, None]) * along
    frame = batch.frames[0]
    return ContactForces(force @ frame, places @ frame)
