"""Where the points of the backbone are, for many poses at once.

Pinocchio gives one pose a call; a fit asks for a hundred thousand. All joint axes of the arm are parallel, so link i is turned by
theta_i = q_1 + ... + q_i about that axis and every point is linear in cos(theta) and sin(theta): two matrix products.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.robot.model import ArmModel
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class MarkerMap:
    """Linear map from cosines and sines of the link angles to marker positions.

    Attributes:
        constant: (3M,) [m] the part that no joint moves.
        cosine, sine: (N, 3M) [m].
        link: (M,) joint that carries each marker, from 0; -1: fixed to the base.
        direction, normal: (3,) of the straight arm, and towards positive bending, in the world frame.
    """

    constant: Array
    cosine: Array
    sine: Array
    link: tuple[int, ...]
    direction: Array
    normal: Array

    def positions(self, joint_angles: Array) -> Array:
        """(..., M, 3) [m] in the world frame, for joint angles (..., N) [rad]."""
        theta = np.cumsum(joint_angles, axis=-1)
        points = np.cos(theta) @ self.cosine + np.sin(theta) @ self.sine + self.constant
        return np.asarray(points.reshape(*joint_angles.shape[:-1], len(self.link), 3))

    def jacobian(self, joint_angles: Array) -> Array:
        """(M, 3, N) [m/rad] derivatives of the positions to the joint angles (N,) [rad]."""
        theta = np.cumsum(joint_angles)[:, None]
        to_links = np.cos(theta) * self.sine - np.sin(theta) * self.cosine  # (N, 3M): joint i turns link i and all further ones
        return np.asarray(to_links[::-1].cumsum(axis=0)[::-1].T.reshape(len(self.link), 3, -1))

    def normals(self, joint_angles: Array) -> Array:
        """(..., M, 3) unit vectors across the backbone at the markers, towards positive bending."""
        theta = np.cumsum(joint_angles, axis=-1)
        padded = np.concatenate([theta, np.zeros_like(theta[..., :1])], axis=-1)[..., list(self.link)]
        return np.asarray(np.cos(padded)[..., None] * self.normal - np.sin(padded)[..., None] * self.direction)


def marker_map(arm: ArmModel, arc_lengths: Array) -> MarkerMap:
    """The map for points at ``arc_lengths`` (M,) [m] from the base along the backbone."""
    specification, direction, normal = arm.specification, arm.direction, arm.normal
    joints = specification.joint_arc_lengths * specification.length
    reach = np.asarray(arc_lengths, dtype=float)
    ends = np.append(joints[1:], np.inf)
    # (N, M): how far each marker reaches along each link
    spans = np.clip(reach[None, :], joints[:, None], ends[:, None]) - joints[:, None]
    fixed = np.minimum(reach, joints[0])
    return MarkerMap(
        constant=(fixed[:, None] * direction).ravel(),
        cosine=(spans[:, :, None] * direction).reshape(len(joints), -1),
        sine=(spans[:, :, None] * normal).reshape(len(joints), -1),
        link=tuple(int(np.searchsorted(joints, s, side="left")) - 1 for s in reach),
        direction=direction,
        normal=normal,
    )
