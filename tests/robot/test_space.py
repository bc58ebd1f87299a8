"""Points of an arm in space are where Pinocchio has them; rotations are its own; the base points where it is told."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import scipy.linalg

from hsr_pin.robot.chain import Arms
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.rotations import left_jacobians, rotations, vectors
from hsr_pin.robot.space import base_rotations, space_model
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification, joint_arc_lengths, link_shares

ARM = ArmSpecification(links=4, placement="mid", mount="horizontal", tilt=0.3, cross_tilt=-0.5, tip_mass=0.02, bending="space")
PLACES = np.array([0.0, 0.02, 0.13, 0.24])


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-3, 0.015, 0.5, 3.0])
def test_rotations_and_their_jacobians_are_pinocchios(size):
    w = size * np.array([[0.6, -0.5, 0.4], [0.1, 0.9, -0.3]])
    for one, turn, jacobian in zip(w, rotations(w), left_jacobians(w), strict=True):
        np.testing.assert_allclose(turn, pin.exp3(one), atol=1e-14)
        np.testing.assert_allclose(jacobian, pin.exp3(one) @ pin.Jexp3(one), atol=1e-13)


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
@pytest.mark.parametrize("placement", ["base", "mid", "shifted"])
def test_points_are_where_pinocchio_has_them(placement, mount):
    arm = replace(ARM, placement=placement, mount=mount)
    q = np.random.default_rng(1).normal(0, 0.6, (arm.links, 3))
    model = space_model(arm)
    data = model.createData()
    pin.forwardKinematics(model, data, np.concatenate([pin.Quaternion(pin.exp3(w)).coeffs() for w in vectors(q)]))
    starts, base = joint_arc_lengths(arm.links, arm.placement) * arm.length, base_rotations(Arms.of([arm]))[0]
    beside = np.array([0.01j, 0.02 + 0.01j, 0.0, -0.03])
    for place, off, got in zip(PLACES, beside, space_marker_map(arm, PLACES, beside).positions(q.ravel()), strict=True):
        link = int(np.count_nonzero(starts < place))
        own = np.array([off.real, off.imag, place - starts[link - 1] if link else place])
        wanted = data.oMi[link].act(own) if link else base @ own
        np.testing.assert_allclose(got, wanted, atol=1e-14)


def test_in_the_plane_they_are_todays():
    arm = ArmSpecification(links=5, placement="mid", tilt=0.3, mount="hanging")
    q = np.random.default_rng(2).normal(0, 0.4, (7, 5))
    whole = np.zeros((7, 5, 3))
    whole[..., 0] = q
    space = space_marker_map(replace(arm, bending="space"), PLACES)
    np.testing.assert_allclose(space.turned(whole.reshape(7, 15)), np.abs(marker_map(arm, PLACES).turned(q)), atol=1e-14)
    for name in ("positions", "normals"):
        np.testing.assert_allclose(
            getattr(space, name)(whole.reshape(7, 15)), getattr(marker_map(arm, PLACES), name)(q), atol=1e-14
        )


def test_velocities_are_differences_of_positions():
    random = np.random.default_rng(3)
    q, v = random.normal(0, 0.6, (2, 6, 12))
    places = space_marker_map(ARM, PLACES, [0.01, 0.02j, 0.01, 0.0])
    ahead, behind = (places.positions(q + h * v) for h in (1e-6, -1e-6))
    np.testing.assert_allclose(places.velocities(q, v), (ahead - behind) / 2e-6, atol=1e-8)


def test_many_arms_side_by_side_keep_to_their_own():
    arms = Arms.of([replace(ARM, length=length, tilt=tilt) for length, tilt in ((0.2, 0.0), (0.3, 0.4), (0.25, -0.2))])
    q = np.random.default_rng(4).normal(0, 0.5, (5, 3, 12))
    reach = np.array([[0.0, 0.2], [0.1, 0.3], [0.05, 0.25]])
    together = space_marker_map(arms, reach, [0.01, 0.02j])
    for b in range(3):
        alone = space_marker_map(arms.specification(b), reach[b], [0.01, 0.02j])
        for name in ("positions", "normals"):
            np.testing.assert_allclose(getattr(together, name)(q)[:, b], getattr(alone, name)(q[:, b]), atol=1e-15)


@pytest.mark.parametrize("placement", ["base", "mid", "shifted"])
@pytest.mark.parametrize("links", [1, 2, 3, 9])
def test_links_fill_the_arm_from_joint_to_joint(links, placement):
    shares, joints = link_shares(links, placement), joint_arc_lengths(links, placement)
    np.testing.assert_allclose(shares.cumsum()[:-1] / links, joints, atol=1e-15)
    assert shares.sum() == pytest.approx(links)


@pytest.mark.parametrize(("placement", "order"), [("mid", 2), ("shifted", 3)])
def test_the_first_frequency_converges_to_a_cantilevers(placement, order):
    """3.516 sqrt(EI / (mu L^4)) of a thin beam, with EI = Keq L."""
    errors = []
    for links in (10, 20):
        arm = ArmSpecification(links, placement=placement, diameter=1e-4, bending="space")
        model = space_model(arm)
        upper = np.triu(pin.crba(model, model.createData(), np.tile([0.0, 0.0, 0.0, 1.0], links)))
        across = (upper + np.triu(upper, 1).T)[0::3, 0::3]
        slowest = np.sqrt(scipy.linalg.eigh(links * arm.keq * np.eye(links), across, eigvals_only=True)[0])
        errors.append(slowest / (3.5160152685 * np.sqrt(arm.keq / (arm.mass * arm.length**2))) - 1)
    assert errors[0] > errors[1] > 0
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
