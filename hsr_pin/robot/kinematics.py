"""Where the points of the backbone are, for many poses at once.

Pinocchio gives one pose a call; a fit asks for a hundred thousand. All joint axes of the arm are parallel, so link i is turned by
theta_i = q_1 + ... + q_i about that axis and every point is linear in cos(theta) and sin(theta): two matrix products.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification, joint_arc_lengths
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class MarkerMap:
    """Linear map from cosines and sines of the link angles to marker positions, for one arm or for C of them side by side.

    Attributes:
        fixed: (C, M) [m] the part along the base, which no joint moves.
        spans: (C, N, M) [m] how far each marker reaches along each link.
        link: (C, M) joint that carries each marker, from 0; -1: fixed to the base.
        direction, normal: (C, 3) of the straight arm, and towards positive bending, in the world frame.
    """

    fixed: Array
    spans: Array
    link: NDArray[np.intp]
    direction: Array
    normal: Array

    @cached_property
    def axis(self) -> Array:
        """(3,) of all joints, in the world frame."""
        return np.cross(self.direction[0], self.normal[0])

    def positions(self, joint_angles: Array) -> Array:
        """(..., M, 3) [m] in the world frame, for joint angles (..., N) [rad]; with C > 1 arms (..., C, M, 3) for (..., C, N)."""
        theta = np.cumsum(joint_angles, axis=-1)
        return self._in_world(np.cos(theta), np.sin(theta), self.fixed)

    def velocities(self, joint_angles: Array, joint_rates: Array) -> Array:
        """As :meth:`positions`, [m/s]: how fast the points move, for joint rates [rad/s] of the same shape as the angles."""
        theta, rate = np.cumsum(joint_angles, axis=-1), np.cumsum(joint_rates, axis=-1)
        return self._in_world(-np.sin(theta) * rate, np.cos(theta) * rate, np.zeros_like(self.fixed))

    def _in_world(self, cosine: Array, sine: Array, fixed: Array) -> Array:
        """What is along and across the base for each link, spanned by the links, in the world frame."""
        one = len(self.fixed) == 1
        along, across = self._spanned(cosine) + (fixed[0] if one else fixed), self._spanned(sine)
        direction, normal = (self.direction[0], self.normal[0]) if one else (self.direction[:, None], self.normal[:, None])
        world = np.empty((*along.shape, 3))
        for axis in range(3):  # by axis: NumPy is slow where the innermost axis is short
            world[..., axis] = along * direction[..., axis] + across * normal[..., axis]
        return world

    def _spanned(self, parts: Array) -> Array:
        """(..., C, M) from (..., C, N): one product of matrices for each arm."""
        if len(self.fixed) == 1:
            return np.asarray(parts @ self.spans[0])
        by_arm = parts.reshape(-1, *parts.shape[-2:]).swapaxes(0, 1)
        return np.asarray((by_arm @ self.spans).swapaxes(0, 1).reshape(*parts.shape[:-1], -1))

    def jacobian(self, joint_angles: Array) -> Array:
        """(M, 3, N) [m/rad] derivatives of the positions of one arm to its joint angles (N,) [rad]."""
        theta = np.cumsum(joint_angles)[:, None]
        along, across = -np.sin(theta) * self.spans[0], np.cos(theta) * self.spans[0]  # (N, M) to the link angles
        to_links = along[..., None] * self.direction[0] + across[..., None] * self.normal[0]
        return np.asarray(to_links[::-1].cumsum(axis=0)[::-1].transpose(1, 2, 0))  # joint i turns link i and all further ones

    def sways(self, joint_angles: Array, shapes: Array) -> Array:
        """(T, M, 3, K) [m/rad] derivatives of one arm's positions at joint angles (T, N) to amplitudes of shapes (N, K)."""
        theta = np.cumsum(joint_angles, axis=1)
        way = np.cos(theta)[..., None] * self.normal[0] - np.sin(theta)[..., None] * self.direction[0]  # (T, N, 3)
        turn = (self.spans[0][None, :, :, None] * way[:, :, None]).reshape(*theta.shape, -1)  # (T, N, 3M) d p / d theta
        found = np.einsum("tnx,nk->txk", turn, np.cumsum(shapes, axis=0))
        return np.asarray(found.reshape(len(theta), -1, 3, shapes.shape[1]))

    def normals(self, joint_angles: Array) -> Array:
        """(..., M, 3) unit vectors across the backbone at the markers, towards positive bending."""
        return self._turned_by(self.turned(joint_angles) + np.pi / 2)

    def tangents(self, joint_angles: Array) -> Array:
        """(..., M, 3) unit vectors along the backbone at the markers, towards the tip."""
        return self._turned_by(self.turned(joint_angles))

    def _turned_by(self, angles: Array) -> Array:
        """(..., M, 3) the direction of the straight arm, turned by angles (..., M) [rad]."""
        one = len(self.fixed) == 1
        direction, normal = (self.direction[0], self.normal[0]) if one else (self.direction[:, None], self.normal[:, None])
        return np.asarray(np.cos(angles)[..., None] * direction + np.sin(angles)[..., None] * normal)

    def turned(self, joint_angles: Array) -> Array:
        """(..., M) [rad] angles from the base to the backbone at the markers."""
        theta = np.cumsum(joint_angles, axis=-1)
        padded = np.concatenate([theta, np.zeros_like(theta[..., :1])], axis=-1)
        if len(self.fixed) == 1:
            return np.asarray(padded[..., self.link[0]])
        return np.asarray(padded[..., np.arange(len(self.link))[:, None], self.link])


def marker_map(arm: ArmSpecification | Arms, arc_lengths: ArrayLike) -> MarkerMap:
    """The map for points at ``arc_lengths`` (M,) or (B, M) [m] from the base along the backbone."""
    arms = Arms.of([arm]) if isinstance(arm, ArmSpecification) else arm
    reach = np.atleast_2d(np.asarray(arc_lengths, dtype=float))[:, None]  # (1, 1, M) or (B, 1, M)
    if all(np.ptp(values, axis=0).max(initial=0.0) == 0 for values in (arms.length, arms.tilt, reach)):
        arms, reach = arms.columns(slice(0, 1)), reach[:1]
    direction, normal = arms.frame()
    joints = (joint_arc_lengths(arms.links, arms.placement) * arms.length[:, None])[..., None]  # (C, N, 1)
    ends = np.append(joints[:, 1:], np.full((len(joints), 1, 1), np.inf), axis=1)
    return MarkerMap(
        fixed=np.minimum(reach, joints[:, :1])[:, 0],
        spans=np.clip(reach, joints, ends) - joints,
        link=np.count_nonzero(joints < reach, axis=1) - 1,
        direction=direction,
        normal=normal,
    )
