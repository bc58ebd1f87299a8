"""Arms of sections: two torques for each, in the model, in rest poses, in feedback laws, and stepped by hand."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reach import rest_at_tip, rest_under, static_pose
from hsr_pin.control.reference import reference_through_tips
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Section

from .loops import check_linear, missed_distances

TWO = (Section(0.14, 0.10, 1.6, 0.09), Section(0.10, 0.05, 1.4, 0.06))
ARM = ArmSpecification.in_sections(TWO, links=4, placement="mid")
TORQUE = np.array([0.5, 0.2, -0.4, 0.3])
TIME = np.arange(31) * 0.01
COMMANDS = np.where(TIME[:, None] < 0.12, TORQUE, [-0.2, 0.3, 0.6, 0.0])


def test_sections_under_one_torque_are_one_arm():
    half = Section(0.12, 0.075, 2.22, 0.1)
    whole = ArmDynamics(ArmSpecification(4, placement="mid", bending="space"))
    parts = ArmDynamics(ArmSpecification.in_sections((half, half), links=4, placement="mid"))
    q, v = 0.2 * np.random.default_rng(3).normal(size=(2, 4, 3)) * [1, 1, 0]
    np.testing.assert_allclose(parts.b[:, :2] + parts.b[:, 2:], whole.b)
    np.testing.assert_allclose(parts.forward(q, v, [0.3, 0.1, 0.3, 0.1]), whole.forward(q, v, [0.3, 0.1]), atol=1e-8)
    np.testing.assert_allclose(static_pose(parts, [0.3, 0.1, 0.3, 0.1]), static_pose(whole, [0.3, 0.1]), atol=1e-10)


def test_forward_undoes_inverse():
    dynamics = ArmDynamics(ARM)
    q, v = 0.2 * np.random.default_rng(4).normal(size=(2, 4, 3)) * [1, 1, 0]
    needed = dynamics.inverse(q, v, dynamics.forward(q, v, TORQUE))
    assert dynamics.b.shape == (12, 4)
    np.testing.assert_allclose(needed[dynamics.moves], (dynamics.b @ TORQUE)[dynamics.moves], atol=1e-9)
    np.testing.assert_allclose(dynamics.uniform(dynamics.b @ TORQUE), TORQUE, atol=1e-12)


def test_linearised_each_torque_moves_what_it_does_in_the_simulation():
    check_linear(ArmDynamics(ARM), TORQUE)


@pytest.mark.parametrize(
    "words", [(), ("actuator_lag:time_constant=0.03", "dead_time:delay=0.023")], ids=["plain", "remembering"]
)
@pytest.mark.parametrize("dynamics", ["compiled", "rnea"])
def test_stepping_is_simulating(words, dynamics):
    effects = tuple(map(parse_effect, words))
    simulator = ArmSimulator(ARM, effects, step=0.005, dynamics=dynamics)
    simulator.reset(TORQUE)
    states = [simulator.state] + [simulator.step(u.reshape(2, 2), dt=0.01) for u in COMMANDS[:-1]]
    held = Settled((0.5 + 0.2j, -0.4 + 0.3j))
    run = simulate(Scenario(ARM, TIME, COMMANDS, held, effects), dynamics="compiled", step=0.005, integrator="extrapolated4")
    np.testing.assert_allclose([state.angles for state in states], run.trajectory.joint_angles, rtol=0, atol=1e-8)


def test_sections_bring_the_tip_where_one_torque_cannot():
    dynamics = ArmDynamics(ARM)
    wanted = rest_under(dynamics, (1.6, 0.0, -2.0, 0.2))
    found = rest_at_tip(dynamics, wanted.tip, (0.0, 2.5))
    assert found.distance < 1e-5
    assert np.linalg.norm(found.torque.reshape(2, 2), axis=1).max() <= 2.5
    alone = rest_at_tip(ArmDynamics(replace(ARM, sections=())), wanted.tip, (0.0, 2.5))
    assert alone.distance > 5e-3


def test_loops_that_are_closed_follow_better_than_those_that_are_not():
    dynamics = ArmDynamics(ARM)
    tips = [rest_under(dynamics, u).tip for u in ((0.0, 0.0, 0.0, 0.0), (0.6, 0.1, -0.2, 0.3), (-0.1, 0.5, 0.5, 0.0))]
    reference = reference_through_tips(dynamics, tips, (0.0, 1.5), move=0.4, hold=0.2)
    assert reference.torque.shape == (len(reference.time), 4)
    # the section at the tip is light, and w^2 M is all that holds it
    missed = missed_distances(dynamics, reference, 150.0, (0.2, 0.1, 0.2, 0.1))
    assert missed["open"] > 0.01
    for name, share in (("pd", 0.4), ("computed", 0.7), ("lqr", 0.4)):
        assert missed[name] < share * missed["open"]


@pytest.mark.parametrize("torque", [(0.1, 0.2), (0.1, 0.2, 0.3), np.zeros((4, 1)), (0.0, 0.0, 9.0, 0.0), "up"])
def test_a_command_of_other_sections_is_refused(torque):
    with pytest.raises(InputError, match="for each of 2 sections, towards x and towards y, up to"):
        ArmSimulator(ARM).step(torque)


def test_what_no_motion_tells_apart_is_refused():
    with pytest.raises(InputError, match="links: expected at least 2, one for each section, got 1"):
        ArmDynamics(replace(ARM, links=1))
    with pytest.raises(InputError, match=r"two components \[N m\] for each of 2 sections"):
        static_pose(ArmDynamics(ARM), (0.1, 0.2))
