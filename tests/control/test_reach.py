"""The arm at rest: under a torque, and with its tip as near to a point as it comes."""

import numpy as np
import pytest

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reach import compliance, rest_at_tip, rest_under, static_pose
from hsr_pin.control.reference import reference_from_torque, reference_through_tips
from hsr_pin.effects import parse_effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification

MODEL = ArmDynamics(ArmSpecification(), [parse_effect("stiffness_gradient:slope=0.6"), parse_effect("tip_mass:mass=0.03")])
RANGE = (-1.5, 1.2)


def test_nothing_moves_in_a_static_pose():
    torques = np.array([[-1.4, 0.0], [0.3, 1.1]])
    poses = static_pose(MODEL, torques)
    assert poses.shape == (2, 2, 4)
    for q, u in zip(poses.reshape(-1, 4), torques.ravel(), strict=True):
        np.testing.assert_allclose(MODEL.inverse(q, np.zeros(4), np.zeros(4)), u, rtol=0, atol=1e-10)


def test_the_compliance_is_how_the_pose_changes_with_the_torque():
    q = static_pose(MODEL, [0.6 - 1e-5, 0.6, 0.6 + 1e-5])
    np.testing.assert_allclose(compliance(MODEL, q[1], 0.6), (q[2] - q[0]) / 2e-5, rtol=1e-6)


@pytest.mark.parametrize("torque", [-1.5, -0.777, 0.0, 0.4321, 1.2])
def test_the_torque_of_a_tip_position_comes_back(torque):
    found = rest_at_tip(MODEL, rest_under(MODEL, torque).tip, RANGE)
    assert found.torque == pytest.approx(torque, abs=1e-9)
    assert found.distance < 1e-10


@pytest.mark.parametrize("point", [(0.1, -0.15), (0.3, 0.2), (-0.02, -0.3), (0.0, 0.0)])
def test_the_nearest_place_is_taken_where_a_point_is_out_of_reach(point):
    found = rest_at_tip(MODEL, point, RANGE)
    tips = MODEL.tip(static_pose(MODEL, np.linspace(*RANGE, 1001)))[:, [0, 2]]
    nearest = np.linalg.norm(tips - point, axis=1).min()
    assert nearest - 1e-6 < found.distance <= nearest + 1e-12
    assert RANGE[0] <= found.torque <= RANGE[1]


@pytest.mark.parametrize("position", [(0.1, np.nan), (0.1,), 0.1, np.zeros((2, 2))])
def test_a_position_that_is_none_is_refused(position):
    with pytest.raises(InputError, match="tip position"):
        rest_at_tip(MODEL, position, RANGE)


def test_an_empty_range_and_a_torque_that_is_none_are_refused():
    with pytest.raises(InputError, match="torque range"):
        rest_at_tip(MODEL, (0.1, -0.2), (1.0, 1.0))
    with pytest.raises(InputError, match="torque: expected finite"):
        static_pose(MODEL, np.nan)


def test_a_reference_goes_through_its_tips_and_rests_there():
    tips = np.array([rest_under(MODEL, u).tip for u in (0.0, 0.8, -0.5)])
    reference = reference_through_tips(MODEL, tips, RANGE, move=0.6, hold=0.3)
    at = [round(t / reference.step) for t in (0.15, 1.05, 1.95)]
    np.testing.assert_allclose(reference.tip[at], tips, rtol=0, atol=1e-8)
    np.testing.assert_allclose(reference.v[at], 0.0, atol=1e-4)
    assert reference.time[-1] == pytest.approx(2.1)


def test_the_rates_of_a_reference_are_those_of_its_angles():
    time = np.arange(201) * 0.01
    reference = reference_from_torque(MODEL, time, 0.5 + 0.4 * np.sin(3 * time))
    inner = slice(10, -10)
    np.testing.assert_allclose(np.gradient(reference.q, 0.01, axis=0)[inner], reference.v[inner], atol=1e-3)
    np.testing.assert_allclose(np.gradient(reference.v, 0.01, axis=0)[inner], reference.a[inner], atol=3e-3)


@pytest.mark.parametrize("time", [np.arange(4.0), np.zeros(8), np.arange(7.0)])
def test_a_reference_without_a_torque_for_each_time_is_refused(time):
    with pytest.raises(InputError, match="reference"):
        reference_from_torque(MODEL, time, np.zeros(len(time) if len(time) == 8 else 8) if len(time) != 4 else np.zeros(4))
