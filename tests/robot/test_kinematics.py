"""The marker map is Pinocchio's forward kinematics, for any pose, place and mount."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.robot.chain import Arms
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification

ARMS = [
    ArmSpecification(links=links, placement=placement, mount=mount, tilt=tilt)
    for links, tilt in ((1, 0.0), (2, -0.4), (5, 0.2), (16, 3.0))
    for placement in ("base", "mid")
    for mount in ("hanging", "upright", "horizontal", "flat")
]
arms = pytest.mark.parametrize("arm", ARMS, ids=lambda a: f"{a.links}-{a.placement}-{a.mount}")


def places(arm):
    """At the ends, at every joint, half-way between joints and at random."""
    joints = arm.joint_arc_lengths * arm.length
    between = (np.append(joints[1:], arm.length) + joints) / 2
    return np.concatenate([[0.0, arm.length], joints, between, np.random.default_rng(0).uniform(0, arm.length, 5)])


def on_link(arm, model, data, s):
    """Placement of the frame that carries the point at arc length s [m], with its origin there."""
    joints = arm.joint_arc_lengths * arm.length
    number = int(np.sum(joints < s))
    if number == 0:
        return data.oMf[model.getFrameId("base")] * pin.SE3(np.eye(3), np.array([0.0, 0.0, s]))
    return data.oMi[number] * pin.SE3(np.eye(3), np.array([0.0, 0.0, s - joints[number - 1]]))


def frames(arm, q, reach):
    model = build_model(arm).model
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return [on_link(arm, model, data, s) for s in reach]


@arms
def test_positions_are_those_of_pinocchio(arm):
    reach = places(arm)
    q = np.random.default_rng(1).normal(0, 1, (20, arm.links))
    expected = [[frame.translation for frame in frames(arm, pose, reach)] for pose in q]
    np.testing.assert_allclose(marker_map(arm, reach).positions(q), expected, rtol=0, atol=1e-14)


@arms
def test_normals_are_the_x_axes_of_the_links(arm):
    reach = places(arm)
    q = np.random.default_rng(2).normal(0, 1, (20, arm.links))
    expected = [[frame.rotation[:, 0] for frame in frames(arm, pose, reach)] for pose in q]
    np.testing.assert_allclose(marker_map(arm, reach).normals(q), expected, rtol=0, atol=1e-14)


@arms
def test_base_middle_and_tip_are_the_frames_of_the_urdf(arm):
    model = build_model(arm).model
    data, q = model.createData(), np.random.default_rng(3).normal(0, 1, arm.links)
    pin.framesForwardKinematics(model, data, q)
    expected = [data.oMf[model.getFrameId(name)].translation for name in ("base", "middle", "tip")]
    reach = np.array([0, arm.length / 2, arm.length])
    np.testing.assert_allclose(marker_map(arm, reach).positions(q), expected, rtol=0, atol=1e-14)


def test_leading_dimensions_are_kept():
    places = marker_map(ArmSpecification(links=3), np.array([0.1, 0.2]))
    assert places.positions(np.zeros((7, 5, 3))).shape == places.normals(np.zeros((7, 5, 3))).shape == (7, 5, 2, 3)


@arms
def test_arms_side_by_side_are_each_what_they_are_alone(arm):
    family = [arm, replace(arm, length=0.3), replace(arm, tilt=arm.tilt / 2 + 0.1), replace(arm, mass=0.5)]
    reach = places(arm)
    q = np.random.default_rng(4).normal(0, 1, (6, len(family), arm.links))
    together = marker_map(Arms.of(family), reach)
    for hook in ("positions", "normals"):
        found = getattr(together, hook)(q)
        expected = np.stack([getattr(marker_map(one, reach), hook)(q[:, c]) for c, one in enumerate(family)], axis=1)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


@arms
def test_velocities_are_how_positions_change(arm):
    family = Arms.of([arm, replace(arm, length=0.3)])
    reach = places(arm) * np.array([[1.0], [1.25]])  # (2, M): each arm has places of its own
    q, v = np.random.default_rng(5).normal(0, 1, (2, 6, 2, arm.links))
    for where, angles, rates in ((marker_map(family, reach), q, v), (marker_map(arm, reach[0]), q[:, 0], v[:, 0])):
        ahead, behind = (where.positions(angles + w * rates) for w in (1e-6, -1e-6))
        np.testing.assert_allclose(where.velocities(angles, rates), (ahead - behind) / 2e-6, rtol=0, atol=1e-8)


@arms
def test_the_jacobian_is_that_of_pinocchio(arm):
    reach = places(arm)
    q = np.random.default_rng(2).normal(0, 1, arm.links)
    model = build_model(arm).model
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    found = marker_map(arm, reach).jacobian(q)
    for jacobian, s, frame in zip(found, reach, frames(arm, q, reach), strict=True):
        number = int(np.sum(arm.joint_arc_lengths * arm.length < s))
        if number == 0:
            assert not jacobian.any()
            continue
        at_joint = pin.getJointJacobian(model, data, number, pin.LOCAL_WORLD_ALIGNED).reshape(6, arm.links)
        arm_of_force = frame.translation - data.oMi[number].translation
        expected = at_joint[:3] + np.cross(at_joint[3:].T, arm_of_force).T
        np.testing.assert_allclose(jacobian, expected, rtol=0, atol=1e-14)
