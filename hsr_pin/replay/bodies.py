"""Visuals of the arm from its URDF, and their poses by the forward kinematics of Pinocchio or, in space, of hsr_pin."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from hsr_pin.robot.model import build_model
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf
from hsr_pin.trajectory import Array

#: Rotation of cylinders, which are along z in a URDF and along y in meshcat.
_Z_TO_Y = pin.SE3(pin.utils.rotate("x", math.pi / 2), np.zeros(3)).homogeneous


@dataclass(frozen=True, eq=False)
class Body:
    """One visual of the arm.

    Attributes:
        name: name in the URDF, with a number.
        joint: number of the joint that carries it, from 1; 0: fixed.
        placement: (4, 4) pose of the sphere, or of the cylinder along y, in the frame of the joint.
        radius: radius [m].
        height: height of a cylinder [m]; None: a sphere.
        colour: colour 0xRRGGBB.
    """

    name: str
    joint: int
    placement: Array
    radius: float
    height: float | None
    colour: int


def bodies(arm: ArmSpecification) -> list[Body]:
    """Return all visuals of an arm; an arm in space has those of the straight arm in the plane."""
    arm = replace(arm, bending="plane", torsion=math.inf, cross_tilt=0.0, sections=())
    model = build_model(arm).model
    visuals = pin.buildGeomFromUrdfString(model, arm_to_urdf(arm), pin.GeometryType.VISUAL)
    found = []
    for visual in visuals.geometryObjects:
        half = getattr(visual.geometry, "halfLength", None)
        placement = visual.placement.homogeneous
        red, green, blue = (round(255 * float(part)) for part in visual.meshColor[:3])
        found.append(
            Body(
                name=visual.name,
                joint=int(visual.parentJoint),
                placement=placement if half is None else placement @ _Z_TO_Y,
                radius=float(visual.geometry.radius),
                height=None if half is None else 2 * float(half),
                colour=red << 16 | green << 8 | blue,
            )
        )
    return found


def poses(arm: ArmSpecification, angles: Array) -> tuple[Array, Array]:
    """Return translations (T, N + 1, 3) [m] and quaternions (T, N + 1, 4), x y z w, of base and joints in the world frame.

    Args:
        arm: the arm.
        angles: (T, N) joint angles [rad], in space (T, N, 3).
    """
    if arm.bending == "space":
        return _poses_in_space(arm, angles)
    model = build_model(arm).model
    base = model.frames[model.getFrameId("base")].placement  # Pinocchio's data of 1000 links takes 20 GB
    turned = np.pad(np.cumsum(angles, axis=1), ((0, 0), (1, 0)))[:, :, None]
    lengths = np.diff(arm.joint_arc_lengths, prepend=0.0) * arm.length
    ways = lengths[:, None] * (np.cos(turned) * base.rotation[:, 2] + np.sin(turned) * base.rotation[:, 0])[:, :-1]
    translations = base.translation + np.pad(np.cumsum(ways, axis=1), ((0, 0), (1, 0), (0, 0)))
    x, y, z, w = pin.Quaternion(base.rotation).coeffs()
    quaternions = np.cos(turned / 2) * np.array([x, y, z, w]) + np.sin(turned / 2) * np.array([-z, w, x, -y])  # about y
    return translations, quaternions


def _poses_in_space(arm: ArmSpecification, angles: Array) -> tuple[Array, Array]:
    places = space_marker_map(arm, [0.0])
    frames = places.frames(angles)
    joints = places.joints(frames, arm.joint_arc_lengths * arm.length)
    translations = np.concatenate([np.zeros_like(joints[:, :1]), joints], axis=1)
    quaternions = [[pin.Quaternion(each).coeffs() for each in pose] for pose in frames]
    return translations, np.array(quaternions)
