"""Positions of points on the backbone of planar arms, for many poses at once.

Pinocchio computes one pose per call; a fit needs a hundred thousand. All joint axes of the arm are parallel, so link i is rotated
by theta_i = q_1 + ... + q_i about their direction, and every point is linear in cos(theta) and sin(theta): two matrix products.
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
    """Linear map from cosines and sines of the link angles to marker positions, for one arm or for C arms in a batch.

    Attributes:
        fixed: (C, M) part along the base, which no joint moves [m].
        spans: (C, N, M) part of each marker's arc length on each link [m].
        link: (C, M) joint that carries each marker, from 0; -1 if it is fixed to the base.
        direction, normal: (C, 3) directions of the straight arm and of positive bending, in the world frame.
    """

    fixed: Array
    spans: Array
    link: NDArray[np.intp]
    direction: Array
    normal: Array

    @cached_property
    def axis(self) -> Array:
        """Direction (3,) of all joint axes in the world frame."""
        return np.cross(self.direction[0], self.normal[0])

    def positions(self, joint_angles: Array) -> Array:
        """Return marker positions (..., M, 3) [m] in the world frame, for joint angles (..., N) [rad].

        For C > 1 arms they are (..., C, M, 3) for angles (..., C, N).
        """
        theta = np.cumsum(joint_angles, axis=-1)
        return self._in_world(np.cos(theta), np.sin(theta), self.fixed)

    def velocities(self, joint_angles: Array, joint_rates: Array) -> Array:
        """Return marker velocities [m/s] in the shape of :meth:`positions`, for angles [rad] and rates [rad/s] of one shape."""
        theta, rate = np.cumsum(joint_angles, axis=-1), np.cumsum(joint_rates, axis=-1)
        return self._in_world(-np.sin(theta) * rate, np.cos(theta) * rate, np.zeros_like(self.fixed))

    def _in_world(self, cosine: Array, sine: Array, fixed: Array) -> Array:
        """Combine the components of each link along and across the base into vectors in the world frame."""
        one = len(self.fixed) == 1
        along, across = self._spanned(cosine) + (fixed[0] if one else fixed), self._spanned(sine)
        direction, normal = (self.direction[0], self.normal[0]) if one else (self.direction[:, None], self.normal[:, None])
        world = np.empty((*along.shape, 3))
        for axis in range(3):  # by axis, because NumPy is slow if the innermost axis is short
            world[..., axis] = along * direction[..., axis] + across * normal[..., axis]
        return world

    def _spanned(self, parts: Array) -> Array:
        """Multiply link components (..., C, N) by the spans of each arm, which gives marker components (..., C, M)."""
        if len(self.fixed) == 1:
            return np.asarray(parts @ self.spans[0])
        by_arm = parts.reshape(-1, *parts.shape[-2:]).swapaxes(0, 1)
        return np.asarray((by_arm @ self.spans).swapaxes(0, 1).reshape(*parts.shape[:-1], -1))

    def jacobian(self, joint_angles: Array) -> Array:
        """Return the derivatives (M, 3, N) [m/rad] of one arm's marker positions with respect to its joint angles (N,) [rad]."""
        theta = np.cumsum(joint_angles)[:, None]
        along, across = -np.sin(theta) * self.spans[0], np.cos(theta) * self.spans[0]  # (N, M) to the link angles
        to_links = along[..., None] * self.direction[0] + across[..., None] * self.normal[0]
        return np.asarray(to_links[::-1].cumsum(axis=0)[::-1].transpose(1, 2, 0))  # joint i rotates link i and all links beyond

    def sways(self, joint_angles: Array, shapes: Array) -> Array:
        """Return the derivatives (T, M, 3, K) [m/rad] of one arm's marker positions with respect to shape amplitudes.

        The joint angles are (T, N) [rad], the shapes (N, K).
        """
        theta = np.cumsum(joint_angles, axis=1)
        way = np.cos(theta)[..., None] * self.normal[0] - np.sin(theta)[..., None] * self.direction[0]  # (T, N, 3)
        turn = (self.spans[0][None, :, :, None] * way[:, :, None]).reshape(*theta.shape, -1)  # (T, N, 3M) d p / d theta
        found = np.einsum("tnx,nk->txk", turn, np.cumsum(shapes, axis=0))
        return np.asarray(found.reshape(len(theta), -1, 3, shapes.shape[1]))

    def normals(self, joint_angles: Array) -> Array:
        """Return unit vectors (..., M, 3) normal to the backbone at the markers, towards positive bending."""
        return self._turned_by(self.turned(joint_angles) + np.pi / 2)

    def tangents(self, joint_angles: Array) -> Array:
        """Return unit vectors (..., M, 3) along the backbone at the markers, towards the tip."""
        return self._turned_by(self.turned(joint_angles))

    def _turned_by(self, angles: Array) -> Array:
        """Return the direction of the straight arm rotated by angles (..., M) [rad], (..., M, 3)."""
        one = len(self.fixed) == 1
        direction, normal = (self.direction[0], self.normal[0]) if one else (self.direction[:, None], self.normal[:, None])
        return np.asarray(np.cos(angles)[..., None] * direction + np.sin(angles)[..., None] * normal)

    def turned(self, joint_angles: Array) -> Array:
        """Return the angles (..., M) [rad] from the base to the backbone at the markers."""
        theta = np.cumsum(joint_angles, axis=-1)
        padded = np.concatenate([theta, np.zeros_like(theta[..., :1])], axis=-1)
        if len(self.fixed) == 1:
            return np.asarray(padded[..., self.link[0]])
        return np.asarray(padded[..., np.arange(len(self.link))[:, None], self.link])


def marker_map(arm: ArmSpecification | Arms, arc_lengths: ArrayLike) -> MarkerMap:
    """Return the marker map for points at ``arc_lengths`` (M,) or (B, M) [m] from the base along the backbone."""
    arms = Arms.of([arm]) if isinstance(arm, ArmSpecification) else arm
    reach = np.atleast_2d(np.asarray(arc_lengths, dtype=float))[:, None]  # (1, 1, M) or (B, 1, M)
    if all(np.ptp(values, axis=0).max(initial=0.0) == 0 for values in (arms.length, arms.tilt, reach)):
        arms, reach = arms.subset(slice(0, 1)), reach[:1]
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
