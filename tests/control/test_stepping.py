"""Stepping by hand is simulating, with every effect; the state is all there is; bad commands are refused."""

import copy
import pickle

import numpy as np
import pytest

from hsr_pin.control.latency import step_latency
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import EFFECTS, parse_effect
from hsr_pin.errors import InputError, PressureError, SimulationFailure
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.integrator import STEP
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.simulate import simulate

ARM = ArmSpecification()
TIME = np.arange(41) * 0.01
TORQUE = np.select([TIME < 0.1, TIME < 0.25], [0.9, -0.4], 0.5)
LAG_AND_DELAY = [parse_effect("actuator_lag:time_constant=0.03"), parse_effect("dead_time:delay=0.043")]


def on(name, **options):
    """The effect, a good deal of it."""
    law = EFFECTS[name]
    return law(**{fact.name: fact.neutral + 2 * fact.scale for fact in law.parameters() if fact.amplitude}, **options)


#: No effect, and every effect in all its readings.
CASES = [(), *((on(name, **reading),) for name, law in EFFECTS.items() for reading in law.variants())]


def stepped(simulator, torque=TORQUE, dt=0.01):
    """Marker positions (T, M, 3) and states before the first and after every step."""
    states = [simulator.state] + [simulator.step(u, dt=dt) for u in torque[:-1]]
    return np.array([simulator.observe(state) for state in states]), states


@pytest.mark.parametrize("effects", CASES, ids=str)
def test_stepping_is_simulating_with_every_effect(effects):
    simulator = ArmSimulator(ARM, effects, step=0.005)
    simulator.reset(0.2)
    seen, states = stepped(simulator)
    run = simulate(Scenario(ARM, TIME, TORQUE, Settled(0.2), effects), dynamics="compiled", step=0.005).trajectory
    np.testing.assert_allclose(seen, run.positions, rtol=0, atol=1e-12)
    np.testing.assert_allclose([state.rates for state in states], run.joint_rates, rtol=0, atol=1e-10)
    np.testing.assert_allclose([state.time for state in states], TIME, atol=1e-12)


@pytest.mark.parametrize(
    "how",
    [{"dynamics": "aba"}, {"dynamics": "rnea"}, {"integrator": "extrapolated2"}, {"integrator": "euler", "step": 0.0025}],
    ids=str,
)
def test_stepping_is_simulating_in_every_way(how):
    effects = (*LAG_AND_DELAY, on("torque_map"), on("hysteresis"))
    seen, _ = stepped(ArmSimulator(ARM, effects, **how))
    run = simulate(Scenario(ARM, TIME, TORQUE, Settled(0.0), effects), **{"dynamics": "compiled", "step": STEP} | how).trajectory
    np.testing.assert_allclose(seen, run.positions, rtol=0, atol=1e-12)


@pytest.mark.parametrize("dt", [0.002, 0.01, 0.035])
def test_a_command_goes_through_the_muscles_as_in_a_simulation_whatever_the_step(dt):
    """Held for less than a cell of the command, for two, and for more than a step of the integrator."""
    effects = (on("unequal_lag"), LAG_AND_DELAY[1], on("torque_bias"))
    simulator = ArmSimulator(ARM, effects)
    simulator.reset(TORQUE[0])
    seen, _ = stepped(simulator, dt=dt)
    scenario = Scenario(ARM, np.arange(len(TIME)) * dt, TORQUE, Settled(TORQUE[0]), effects)
    run = simulate(scenario, dynamics="compiled", step=STEP).trajectory
    np.testing.assert_allclose(seen, run.positions, rtol=0, atol=1e-12)


def test_a_pose_starts_the_arm_as_in_a_simulation():
    pose = Pose(np.array([0.1, 0.2, -0.1, 0.05]), np.array([0.0, 1.0, -1.0, 2.0]))
    effects = (*LAG_AND_DELAY, on("viscoelastic"))
    simulator = ArmSimulator(ARM, effects)
    simulator.reset(TORQUE[0], pose=pose)
    seen, _ = stepped(simulator)
    run = simulate(Scenario(ARM, TIME, TORQUE, pose, effects), dynamics="compiled", step=STEP).trajectory
    np.testing.assert_allclose(seen, run.positions, rtol=0, atol=1e-12)


@pytest.mark.parametrize("effects", [(), (LAG_AND_DELAY[0], parse_effect("dead_time:delay=0.05"))], ids=["nominal", "late"])
def test_a_step_may_have_any_length(effects):
    """Two short steps are one long one that the integrator halves itself."""
    once, twice = ArmSimulator(ARM, effects, step=0.005), ArmSimulator(ARM, effects, step=0.005)
    for torque in TORQUE:
        once.step(torque, dt=0.01)
        twice.step(torque, dt=0.005)
        twice.step(torque, dt=0.005)
        np.testing.assert_allclose(twice.state.angles, once.state.angles, rtol=0, atol=1e-12)


def test_pressures_are_the_torque_that_they_give():
    simulator = ArmSimulator(ARM)
    pressures = PAPER.pressures_for_torque(ARM.keq, 0.6)
    by_torque = simulator.advance(simulator.state, 0.6).angles
    np.testing.assert_allclose(simulator.step(pressures=pressures).angles, by_torque, rtol=0, atol=1e-12)


def test_the_state_is_all_there_is():
    simulator = ArmSimulator(ARM, (*LAG_AND_DELAY, on("dry_friction")))
    for torque in TORQUE[:20]:
        middle = simulator.step(torque)
    first, _ = stepped(simulator, TORQUE[20:])
    simulator.reset(1.0)
    simulator.state = middle
    again, _ = stepped(simulator, TORQUE[20:])
    assert np.array_equal(first, again)


def test_to_advance_a_state_leaves_the_simulators_own():
    simulator = ArmSimulator(ARM)
    before = simulator.state
    after = simulator.advance(before, 0.5)
    assert simulator.state is before
    assert np.array_equal(after.angles, simulator.step(0.5).angles)


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
def test_copies_go_their_own_way(duplicate):
    simulator = ArmSimulator(ARM, LAG_AND_DELAY, integrator="extrapolated2", step=0.005)
    simulator.step(0.7)
    twin, alone = duplicate(simulator), ArmSimulator(ARM, LAG_AND_DELAY, integrator="extrapolated2", step=0.005)
    alone.step(0.7)
    for torque in TORQUE:
        simulator.step(torque)
        twin.step(-torque)
        alone.step(torque)
    assert np.array_equal(simulator.state.angles, alone.state.angles)
    assert np.abs(simulator.state.angles - twin.state.angles).max() > 0.01


def test_many_arms_side_by_side_do_not_touch_each_other():
    torques = np.linspace(-0.8, 0.8, 5)
    together = [ArmSimulator(ARM, LAG_AND_DELAY) for _ in torques]
    for _ in range(10):
        for simulator, torque in zip(together, torques, strict=True):
            simulator.step(torque)
    for simulator, torque in zip(together, torques, strict=True):
        alone = ArmSimulator(ARM, LAG_AND_DELAY)
        for _ in range(10):
            alone.step(torque)
        assert np.array_equal(simulator.state.angles, alone.state.angles)


def test_a_state_cannot_be_written_to():
    state = ArmSimulator(ARM, [on("hysteresis")]).step(0.5)
    for values in (state.angles, state.rates, *state.effect_states):
        with pytest.raises(ValueError, match="read-only"):
            values[...] = 0.0
    with pytest.raises(AttributeError):
        state.time = 0.0


@pytest.mark.parametrize(
    ("bad", "error", "message"),
    [
        ({"torque": np.nan}, InputError, r"torque: expected -3.487 to 3.487 N m, got nan"),
        ({"torque": 3.6}, InputError, "torque: expected"),
        ({"torque": "much"}, InputError, "torque: expected"),
        ({"torque": np.zeros(2)}, InputError, "torque: expected"),
        ({"pressures": (np.nan, 1.0)}, PressureError, "pressures: expected finite"),
        ({"pressures": (1.0, 4.5)}, PressureError, "P2: expected a pressure from 0 to 4 bar"),
        ({"pressures": 1.0}, PressureError, "pressures: expected P1 and P2"),
        ({"pressures": np.ones((3, 2))}, PressureError, "one P1 and one P2"),
        ({}, InputError, "got neither"),
        ({"torque": 0.1, "pressures": (1.0, 1.0)}, InputError, "got both"),
        ({"torque": 0.1, "dt": 0.0}, InputError, "dt: expected"),
        ({"torque": 0.1, "dt": np.nan}, InputError, "dt: expected"),
        ({"torque": 0.1, "dt": "soon"}, InputError, "dt: expected"),
    ],
)
def test_a_bad_command_is_refused_and_changes_nothing(bad, error, message):
    simulator = ArmSimulator(ARM)
    before = simulator.state
    with pytest.raises(error, match=message):
        simulator.step(**bad)
    assert simulator.state is before


def test_a_bad_start_is_refused():
    with pytest.raises(InputError, match="torque"):
        ArmSimulator(ARM).reset(np.nan)
    with pytest.raises(InputError, match="4 joint angles"):
        ArmSimulator(ARM).reset(pose=Pose(np.zeros(3)))
    with pytest.raises(SimulationFailure, match="bending limit"):
        ArmSimulator(ARM).reset(pose=Pose(np.ones(4)))


def test_an_arm_bent_beyond_its_limit_fails_with_the_last_good_state():
    simulator = ArmSimulator(ARM, torque_range=(-9.0, 9.0))
    with pytest.raises(SimulationFailure, match=r"in the step from t = .*: the arm bent beyond its limit") as raised:
        for _ in range(100):
            simulator.step(8.0)
    assert raised.value.result is simulator.state
    assert 0 < simulator.state.angles.sum() <= ARM.bending_limit


def test_the_latency_of_a_step_can_be_measured():
    latency = step_latency(ArmSimulator(ARM), steps=50)
    assert 0 < latency.minimum <= latency.median <= latency.worst
    assert latency.minimum < 2e-4  # 0.008 ms on an idle machine
