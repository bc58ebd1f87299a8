"""Positions of points on and off the backbone of arms in space, for many poses at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hsr_pin.robot.chain import Arms
from hsr_pin.robot.rotations import left_jacobians, rotations, vectors
from hsr_pin.robot.space import base_rotations
from hsr_pin.robot.specification import ArmSpecification, joint_arc_lengths
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class SpaceMarkerMap:
    """Map from joint coordinates to marker positions, for one arm in space or for C arms in a batch.

    Attributes:
        base: (C, 3, 3) axes of the bases in the world.
        fixed: (C, M) part along the base, which no joint moves [m].
        spans: (C, N, M) part of each marker's arc length on each link [m].
        link: (C, M) joint that carries each marker, from 0; -1 if it is fixed to the base.
        beside: (C, M, 3) offset of the marker from the backbone in the frame of its link [m].
    """

    base: Array
    fixed: Array
    spans: Array
    link: NDArray[np.intp]
    beside: Array

    @cached_property
    def axis(self) -> Array:
        """Axis (3,) about which the first arm bends towards x, in the world frame."""
        return np.array(self.base[0, :, 1])

    def frames(self, coordinates: Array) -> Array:
        """Return the axes (..., N + 1, 3, 3) of the base and of the links in the world, for coordinates (..., N, 3) [rad]."""
        base = self.base[0] if len(self.base) == 1 else self.base
        turns = rotations(vectors(coordinates))
        found = np.empty((*coordinates.shape[:-2], coordinates.shape[-2] + 1, 3, 3))
        found[..., 0, :, :] = base
        for i in range(coordinates.shape[-2]):
            found[..., i + 1, :, :] = found[..., i, :, :] @ turns[..., i, :, :]
        return found

    def joints(self, frames: Array, starts: Array) -> Array:
        """Return the joint positions (..., N, 3) [m] of one arm, from :meth:`frames` and the joints' arc lengths (N,) [m]."""
        ways = np.diff(starts, prepend=0.0)[:, None] * frames[..., :-1, :, 2]
        return np.asarray(ways.cumsum(axis=-2))

    def positions(self, joint_angles: Array) -> Array:
        """Return marker positions (..., M, 3) [m] in the world frame, for coordinates (..., 3 N) [rad].

        For C > 1 arms they are (..., C, M, 3).
        """
        frames = self.frames(_by_joint(joint_angles))
        base, links = frames[..., 0, :, 2], frames[..., 1:, :, 2]
        fixed, spans = (self.fixed[0], self.spans[0]) if len(self.fixed) == 1 else (self.fixed, self.spans)
        places = np.swapaxes(spans, -1, -2) @ links + fixed[..., None] * base[..., None, :]
        return np.asarray(places + self._turned(frames, self.beside) if self.beside.any() else places)

    def normals(self, joint_angles: Array) -> Array:
        """Return unit vectors (..., M, 3) normal to the backbone at the markers, towards x of their links."""
        return self._axes(joint_angles, 0)

    def tangents(self, joint_angles: Array) -> Array:
        """Return unit vectors (..., M, 3) along the backbone at the markers, towards the tip."""
        return self._axes(joint_angles, 2)

    def sides(self, joint_angles: Array) -> Array:
        """Return unit vectors (..., M, 3) normal to the backbone at the markers, towards y of their links."""
        return self._axes(joint_angles, 1)

    def turned(self, joint_angles: Array) -> Array:
        """Return the bending (..., M) [rad] from the base to the markers: the length of the sum of the bending vectors."""
        bends = _by_joint(joint_angles)[..., :2].cumsum(axis=-2)
        size = np.linalg.norm(bends, axis=-1)[..., None]  # (..., N, 1)
        return np.asarray(self._at_markers(np.concatenate([np.zeros_like(size[..., :1, :]), size], axis=-2), 2)[..., 0])

    def velocities(self, joint_angles: Array, joint_rates: Array) -> Array:
        """Return marker velocities [m/s] in the shape of :meth:`positions`, for rates [rad/s] of the coordinates' shape."""
        q, v = _by_joint(joint_angles), _by_joint(joint_rates)
        frames = self.frames(q)
        omega = angular_velocities(frames, q, v)
        fixed, spans = (self.fixed[0], self.spans[0]) if len(self.fixed) == 1 else (self.fixed, self.spans)
        speeds = np.swapaxes(spans, -1, -2) @ np.cross(omega, frames[..., 1:, :, 2]) + 0.0 * fixed[..., None]
        if not self.beside.any():
            return np.asarray(speeds)
        still = np.concatenate([np.zeros_like(omega[..., :1, :]), omega], axis=-2)
        return np.asarray(speeds + np.cross(self._at_markers(still, 2), self._turned(frames, self.beside)))

    def _axes(self, joint_angles: Array, which: int) -> Array:
        """Return one of the axes of the markers' links in the world, (..., M, 3)."""
        return self._turned(self.frames(_by_joint(joint_angles)), np.broadcast_to(np.eye(3)[which], self.beside.shape))

    def sways(self, joint_angles: Array, shapes: Array) -> Array:
        """Return the derivatives (T, M, 3, K) [m/rad] of one arm's marker positions with respect to shape amplitudes.

        The coordinates are (T, 3 N) [rad], the shapes (3 N, K).
        """
        found = [self.velocities(joint_angles, np.broadcast_to(shape, joint_angles.shape)) for shape in shapes.T]
        return np.stack(found, axis=-1)

    def jacobian(self, joint_angles: Array) -> Array:
        """Return the derivatives (M, 3, 3 N) [m/rad] of one arm's marker positions with respect to its coordinates (3 N,)."""
        return np.asarray(self.sways(joint_angles[None], np.eye(len(joint_angles)))[0])

    def _turned(self, frames: Array, vectors: Array) -> Array:
        """Return vectors (C, M, 3) of the markers' links in the world, (..., M, 3)."""
        own = vectors[0] if len(vectors) == 1 else vectors
        return np.asarray((self._at_markers(frames, 3) @ own[..., None])[..., 0])

    def _at_markers(self, each: Array, rank: int) -> Array:
        """Select, for each marker, the quantity of its link from those of base and links.

        They are (..., N + 1, 3) or, of rank 3, (..., N + 1, 3, 3).
        """
        axis, where = each.ndim - rank, self.link + 1
        if len(where) == 1:
            return np.asarray(np.take(each, where[0], axis=axis))
        return np.stack([each.take(c, axis=axis - 1).take(at, axis=axis - 1) for c, at in enumerate(where)], axis=axis - 1)


def angular_velocities(frames: Array, q: Array, v: Array) -> Array:
    """Return the angular velocities (..., N, 3) [rad/s] of the links in the world.

    The frames are (..., N + 1, 3, 3), coordinates and rates (..., N, 3).
    """
    relative = (left_jacobians(vectors(q)) @ vectors(v)[..., None])[..., 0]
    return np.asarray((frames[..., :-1, :, :] @ relative[..., None])[..., 0].cumsum(axis=-2))


def space_marker_map(arm: ArmSpecification | Arms, arc_lengths: ArrayLike, beside: ArrayLike = 0.0) -> SpaceMarkerMap:
    """Return the marker map for points at ``arc_lengths`` (M,) or (B, M) [m], with complex offsets ``beside`` [m].

    The offsets (M,) or (B, M) are x + y i in the frame of the link.
    """
    arms = Arms.of([arm]) if isinstance(arm, ArmSpecification) else arm
    reach = np.broadcast_to(np.atleast_2d(np.asarray(arc_lengths, dtype=float)), (len(arms), np.shape(arc_lengths)[-1]))
    reach = reach[:, None]  # (B, 1, M)
    joints = (joint_arc_lengths(arms.links, arms.placement) * arms.length[:, None])[..., None]
    ends = np.append(joints[:, 1:], np.full((len(joints), 1, 1), np.inf), axis=1)
    off = np.broadcast_to(np.asarray(beside, dtype=complex), reach[:, 0].shape)
    return SpaceMarkerMap(
        base=base_rotations(arms),
        fixed=np.minimum(reach, joints[:, :1])[:, 0],
        spans=np.clip(reach, joints, ends) - joints,
        link=np.count_nonzero(joints < reach, axis=1) - 1,
        beside=np.stack([off.real, off.imag, np.zeros(off.shape)], axis=-1),
    )


def _by_joint(coordinates: Array) -> Array:
    """Return coordinate rows (..., 3 N) by joint, (..., N, 3)."""
    return coordinates.reshape(*coordinates.shape[:-1], -1, 3)
