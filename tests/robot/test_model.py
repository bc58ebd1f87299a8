"""The Pinocchio model is the arm of the specification: its masses, its pose, its gravity, and nothing else."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.errors import SpecificationError
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

PLACEMENTS, MOUNTS = ("base", "mid"), ("hanging", "upright", "horizontal", "flat")
STRAIGHT = {"hanging": (0, 0, -1), "upright": (0, 0, 1), "horizontal": (1, 0, 0), "flat": (1, 0, 0)}
BENDS_TOWARDS = {"hanging": (1, 0, 0), "upright": (1, 0, 0), "horizontal": (0, 0, -1), "flat": (0, 0, -1)}


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("links", [1, 4, 7])
def test_there_is_one_revolute_joint_a_link_and_no_armature(links, placement):
    model = build_model(ArmSpecification(links=links, placement=placement)).model
    assert model.nq == model.nv == links
    assert np.all(model.armature == 0)


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_the_model_weighs_what_moves(placement):
    arm = ArmSpecification(links=5, placement=placement, tip_mass=0.03)
    fixed = arm.mass / 10 if placement == "mid" else 0.0
    assert pin.computeTotalMass(build_model(arm).model) == pytest.approx(arm.mass + arm.tip_mass - fixed, rel=1e-12)


@pytest.mark.parametrize("mount", MOUNTS)
def test_the_straight_arm_points_where_its_mount_says(mount):
    np.testing.assert_allclose(build_model(ArmSpecification(mount=mount)).direction, STRAIGHT[mount], atol=1e-15)


@pytest.mark.parametrize("mount", MOUNTS)
def test_the_joint_axis_turns_the_arm_to_the_side_it_bends_to(mount):
    arm = build_model(ArmSpecification(mount=mount))
    np.testing.assert_allclose(np.cross(arm.joint_axis, arm.direction), BENDS_TOWARDS[mount], atol=1e-15)


@pytest.mark.parametrize("mount", MOUNTS)
def test_tilt_turns_the_base_towards_positive_bending(mount):
    tilted = build_model(ArmSpecification(mount=mount, tilt=0.3)).direction
    expected = np.cos(0.3) * np.array(STRAIGHT[mount]) + np.sin(0.3) * np.array(BENDS_TOWARDS[mount])
    np.testing.assert_allclose(tilted, expected, atol=1e-15)


def test_gravity_points_down():
    np.testing.assert_array_equal(build_model(ArmSpecification()).model.gravity.linear, [0, 0, -9.81])


def test_arms_that_differ_in_springs_and_dampers_share_one_model():
    arm = ArmSpecification(links=3)
    assert build_model(arm).model is build_model(replace(arm, keq=3.0, damping=0.2)).model


def test_arms_of_different_mass_have_different_models():
    arm = ArmSpecification(links=3)
    assert build_model(arm).model is not build_model(replace(arm, mass=0.2)).model


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_gravity_does_not_act_in_the_plane_of_a_flat_arm(placement):
    """Without gravity in the plane, every joint of an arm of equal springs takes the same share of the torque."""
    arm = ArmSpecification(links=7, mount="flat", placement=placement, tip_mass=0.05, tilt=0.4)
    start = simulate(Scenario(arm, np.array([0.0, 0.1]), np.full(2, 0.7), Settled(0.7))).trajectory.joint_angles[0]
    np.testing.assert_allclose(start, 0.7 / arm.keq / 7, rtol=1e-9)


def test_a_flat_arm_in_space_is_refused():
    with pytest.raises(SpecificationError, match='an arm in space that lies has mount="horizontal"'):
        ArmSpecification(mount="flat", bending="space")
