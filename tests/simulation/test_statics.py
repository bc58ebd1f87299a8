"""A settled arm is where its potential energy is least, and tends to the constant-curvature arc."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import root

from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.equilibrium import imbalance
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

PLACEMENTS, MOUNTS = ("base", "mid"), ("hanging", "upright", "horizontal")


def settled(arm, torque, dynamics="aba"):
    return simulate(Scenario(arm, [0.0, 0.01], [torque, torque], Settled(torque)), dynamics=dynamics).trajectory


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("placement", PLACEMENTS)
def test_gravity_turns_the_joints_as_pinocchio_says(placement, mount):
    arm = ArmSpecification(links=5, placement=placement, mount=mount, tilt=0.2, tip_mass=0.07)
    q = np.random.default_rng(0).normal(size=(4, 5))
    model = build_model(arm).model
    data, found, nothing = model.createData(), np.zeros_like(q), np.zeros_like(q)
    expected = [-pin.computeGeneralizedGravity(model, data, pose) for pose in q]
    imbalance(ArmBatch.of([Scenario(arm, [0.0, 0.01], [0.0, 0.0])] * 4).arrays, q, np.zeros(4), nothing, found)
    np.testing.assert_allclose(found + arm.joint_stiffness * q, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("torque", [0.0, 0.25, 1.0, 3.0])
@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("dynamics", ["compiled", "aba"])
def test_the_settled_pose_is_the_static_equilibrium(dynamics, placement, mount, torque):
    arm = ArmSpecification(links=6, placement=placement, mount=mount, tip_mass=0.1, tilt=0.1)
    reach = np.array([arm.length / 2, arm.length])

    def height_gradient(q):  # of the potential energy, from positions alone
        points, turn = np.arange(1, 2001) / 2000 - 1 / 4000, 1e-4
        places = marker_map(arm, np.append(points * arm.length, arm.length))
        weights = 9.81 * np.append(np.full(2000, arm.mass / 2000), arm.tip_mass)
        up, down = (places.positions(q + s * turn * np.eye(6))[..., 2] @ weights for s in (1, -1))
        return (up - down) / (2 * turn)

    found = root(lambda q: 6 * arm.keq * q + height_gradient(q) - torque, np.zeros(6), tol=1e-9)
    assert found.success
    expected = marker_map(arm, reach).positions(found.x)
    np.testing.assert_allclose(settled(arm, torque, dynamics).positions[0, 1:], expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("torque", [0.0, 1.0])
def test_the_settled_pose_stays_where_it_is(torque):
    arm = ArmSpecification(mount="horizontal", tip_mass=0.1)
    motion = simulate(Scenario(arm, np.arange(101) * 0.01, np.full(101, torque), Settled(torque))).trajectory
    np.testing.assert_allclose(motion.positions, np.broadcast_to(motion.positions[0], motion.positions.shape), atol=1e-11)


@pytest.mark.parametrize(("placement", "order"), [("mid", 2), ("base", 1)])
def test_without_gravity_the_arm_tends_to_the_constant_curvature_arc(placement, order, weightless):
    phi, length = 0.9, ArmSpecification.length
    arc = length / phi * np.array([1 - np.cos(phi), 0, -np.sin(phi)])
    errors = []
    for links in (16, 32):
        arm = ArmSpecification(links=links, placement=placement)
        errors.append(np.linalg.norm(settled(arm, arm.keq * phi).positions[0, -1] - arc))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.05)


def test_without_gravity_every_joint_takes_its_share_of_the_bending(weightless):
    arm = ArmSpecification(links=5)
    np.testing.assert_allclose(settled(arm, 1.0).joint_angles[0], np.full(5, 1.0 / arm.keq / 5), rtol=1e-12)


def test_an_upright_arm_that_must_buckle_still_has_its_straight_equilibrium():
    arm = ArmSpecification(keq=0.05, mount="upright", tip_mass=0.1)
    np.testing.assert_array_equal(settled(arm, 0.0).joint_angles[0], np.zeros(4))
