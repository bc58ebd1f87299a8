"""In space too stepping by hand is simulating: two components of torque in, joints of three coordinates out."""

import copy
import pickle

import numpy as np
import pytest

from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect
from hsr_pin.errors import InputError, SimulationFailure
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker

ARM = ArmSpecification(5, placement="mid", bending="space", torsion=2.0, cross_tilt=0.2)
MARKERS = (Marker("mid", 0.12), Marker("side", 0.24, 0.03, 1.0))
TIME = np.arange(41) * 0.01
TORQUE = np.select([TIME[:, None] < 0.1, TIME[:, None] < 0.25], [[0.6, 0.3], [-0.4, 0.5]], [0.1, -0.7])
CASES = [
    (),
    ("hysteresis:amplitude=0.4,yield_angle=0.1", "viscoelastic:ratio=0.5,time_constant=0.1"),
    ("actuator_lag:time_constant=0.03", "dead_time:delay=0.043"),
    ("turned_actuation:angle=0.4", "unequal_stiffness:along_x=0.2"),
    ("markers_beside:towards_x=0.01,base=zeroed", "weak_chamber:loss=0.5,direction=1"),
]


def stepped(simulator):
    states = [simulator.state] + [simulator.step(u, dt=0.01) for u in TORQUE[:-1]]
    return np.array([simulator.observe(state) for state in states]), states


@pytest.mark.parametrize("words", CASES, ids=str)
@pytest.mark.parametrize("dynamics", ["compiled", "rnea"])
def test_stepping_is_simulating(words, dynamics):
    effects = tuple(map(parse_effect, words))
    simulator = ArmSimulator(ARM, effects, step=0.005, markers=MARKERS, dynamics=dynamics)
    simulator.reset((0.2, -0.1))
    seen, states = stepped(simulator)
    scenario = Scenario(ARM, TIME, TORQUE, Settled(0.2 - 0.1j), effects, MARKERS)
    run = simulate(scenario, dynamics="compiled", step=0.005, integrator="extrapolated4").trajectory
    np.testing.assert_allclose(seen, run.positions, rtol=0, atol=1e-9)
    np.testing.assert_allclose([state.angles for state in states], run.joint_angles, rtol=0, atol=1e-8)
    np.testing.assert_allclose([state.rates for state in states], run.joint_rates, rtol=0, atol=1e-6)


def test_the_state_is_all_there_is():
    simulator = ArmSimulator(ARM, (parse_effect(CASES[1][0]),))
    simulator.step((0.5, 0.4), dt=0.05)
    assert simulator.state.effect_states.shape[1:] == (5, 3) and simulator.state.effect_states[:, 0, 1].any()
    twin, before = pickle.loads(pickle.dumps(copy.copy(simulator))), simulator.state
    ahead = [each.advance(before, (-0.2, 0.6), 0.02).angles for each in (simulator, twin)]
    np.testing.assert_array_equal(*ahead)
    assert simulator.state is before and ahead[0].shape == (5, 3)


def test_a_pose_is_where_it_starts():
    simulator = ArmSimulator(ARM)
    pose = np.linspace(0.0, 0.2, 15).reshape(5, 3)
    state = simulator.reset(pose=Pose(pose))
    np.testing.assert_array_equal(state.angles, pose)
    with pytest.raises(InputError, match="towards x, towards y, twist"):
        simulator.reset(pose=Pose(np.zeros(5)))


@pytest.mark.parametrize("torque", [0.3, (0.1,), (0.1, np.nan), "up", (9.0, 9.0), None])
def test_a_command_that_is_none_is_refused(torque):
    simulator = ArmSimulator(ARM)
    with pytest.raises(InputError, match="torque"):
        simulator.step(torque) if torque is not None else simulator.step(pressures=(1.0, 1.0))


def test_an_arm_that_goes_too_far_is_said_to_and_stays():
    simulator = ArmSimulator(ArmSpecification(4, bending="space", bending_limit=1.0), torque_range=(0.0, 5.0))
    before = simulator.state
    with pytest.raises(SimulationFailure, match="bending limit"):
        for _ in range(100):
            before = simulator.state
            simulator.step((2.0, 2.0), dt=0.01)
    assert simulator.state is before
