"""Controllers in space: the model is that of the simulation, along one axis that of the plane, and loops close about two axes."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.control.controllers import lqr_gain
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.observer import Observer
from hsr_pin.control.reach import rest_at_tip, rest_under, static_pose
from hsr_pin.control.reference import reference_from_torque, reference_through_tips
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.errors import InputError, SpecificationError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Pose
from hsr_pin.trajectory import Marker

from .loops import check_linear, missed_distances

ARM = ArmSpecification(3, placement="mid", bending="space", mount="horizontal", tip_mass=0.02)
SOFT = ArmSpecification(3, placement="mid", bending="space", torsion=0.8)
RANDOM = np.random.default_rng(5)


def state(arm, size=0.2):
    q, v = size * RANDOM.normal(size=(2, arm.links, 3))
    if np.isinf(arm.torsion):
        q[:, 2] = v[:, 2] = 0.0
    return q, 5 * v


@pytest.mark.parametrize("arm", [ARM, SOFT], ids=["stiff in twist", "twisting"])
def test_forward_undoes_inverse_and_coriolis_is_skew(arm):
    dynamics = ArmDynamics(arm)
    q, v = state(arm)
    u = np.array([0.4, -0.2])
    a = dynamics.forward(q, v, u)
    needed = dynamics.inverse(q, v, a)
    np.testing.assert_allclose(needed[dynamics.moves], (dynamics.b @ u)[dynamics.moves], atol=1e-9)
    np.testing.assert_allclose(
        dynamics.M(q) @ a + dynamics.C(q, v) @ v.ravel() + dynamics.G(q) + dynamics.K * q.ravel() + dynamics.D * v.ravel(),
        needed,
        atol=1e-6,
    )
    h = 1e-5
    slope = (dynamics.M(q + h * v) - dynamics.M(q - h * v)) / (2 * h) - 2 * dynamics.C(q, v)
    np.testing.assert_allclose(slope, -slope.T, atol=1e-6)
    np.testing.assert_allclose(dynamics.uniform(dynamics.b @ u), u, atol=1e-12)


@pytest.mark.parametrize("arm", [ARM, SOFT], ids=["stiff in twist", "twisting"])
def test_accelerations_are_those_of_the_simulation(arm):
    arm, h = replace(arm, damping=1e-4), 1e-5
    dynamics = ArmDynamics(arm)
    q, v = state(arm)
    simulator = ArmSimulator(arm, step=1e-6)
    simulator.reset(pose=Pose(q, v))
    after = simulator.step((0.4, -0.2), dt=h)
    a = dynamics.forward(q, v, (0.4, -0.2)).reshape(-1, 3)
    np.testing.assert_allclose((after.rates - v) / h, a, atol=2e-3 * np.abs(a).max())


def test_linearised_it_goes_on_as_the_simulation_does():
    step = check_linear(ArmDynamics(ARM), np.array([0.5, 0.3]))
    assert step.B.shape == (18, 2)
    np.testing.assert_allclose(step.rate, 0.0, atol=1e-7)


def test_along_one_axis_it_is_the_model_of_the_plane():
    flat = ArmSpecification(3, placement="mid", mount="horizontal", tip_mass=0.02)
    plane, space = ArmDynamics(flat), ArmDynamics(ARM)
    q, v = RANDOM.normal(size=(2, 3)) * 0.3
    wide_q, wide_v = np.zeros((2, 3, 3))
    wide_q[:, 0], wide_v[:, 0] = q, v
    along = slice(0, None, 3)
    np.testing.assert_allclose(space.M(wide_q)[along, along], plane.M(q), atol=1e-12)
    np.testing.assert_allclose(space.forward(wide_q, wide_v, (0.3, 0.0))[along], plane.forward(q, v, 0.3), rtol=1e-8)
    for own, other in zip(lqr_gain(space, (0.2, 0.0), 0.01)[0].reshape(-1, 3)[:, 0], lqr_gain(plane, 0.2, 0.01), strict=True):
        assert own == pytest.approx(other, rel=1e-3, abs=1e-6)


def test_the_tip_is_brought_where_it_can_rest():
    dynamics = ArmDynamics(ARM)
    wanted = rest_under(dynamics, (0.4, -0.5))
    found = rest_at_tip(dynamics, wanted.tip, (0.0, 1.0))
    np.testing.assert_allclose(found.torque, (0.4, -0.5), atol=1e-4)
    assert found.distance < 1e-5
    far = rest_at_tip(dynamics, (0.0, 0.3, 0.0), (0.0, 0.5))
    assert np.hypot(*far.torque) == pytest.approx(0.5, abs=1e-3) and far.tip[1] > 0.02
    with pytest.raises(InputError, match="tip position"):
        rest_at_tip(dynamics, (0.1, 0.1), (0.0, 1.0))
    with pytest.raises(InputError, match="two components"):
        static_pose(dynamics, 0.3)


def test_loops_that_are_closed_follow_better_than_those_that_are_not():
    dynamics = ArmDynamics(ARM)
    tips = [rest_under(dynamics, u).tip for u in ((0.0, 0.0), (0.5, 0.2), (-0.1, 0.6))]
    reference = reference_through_tips(dynamics, tips, (0.0, 1.2), move=0.5, hold=0.3)
    assert reference.torque.shape == (len(reference.time), 2) and reference.q.shape[1] == 9
    missed = missed_distances(dynamics, reference, 80.0, (0.2, 0.2))
    assert missed["open"] > 0.01
    for name in ("pd", "computed", "lqr"):
        assert missed[name] < 0.6 * missed["open"]


def test_what_is_not_there_in_space_is_said_so():
    dynamics = ArmDynamics(ARM)
    with pytest.raises(SpecificationError, match="plane for an observer"):
        Observer(dynamics, (Marker("tip", 0.24),), 0.01)
    with pytest.raises(InputError, match="six or more"):
        reference_from_torque(dynamics, np.arange(8.0), np.zeros(8))
