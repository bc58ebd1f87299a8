"""Each method converges at its order, stays stable where explicit ones do not, and costs O(N) a step."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects.viscoelastic import Viscoelastic
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification, default_damping
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.integrators import INTEGRATORS, ExtrapolatedEuler, integrator
from hsr_pin.simulation.integrators.integrator import workspace
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate

methods = pytest.mark.parametrize("name", INTEGRATORS)

#: How far a measured order may stay behind; at order 5 rounding forbids the short steps that would bring it closer.
SLACK = {1: 0.15, 2: 0.15, 3: 0.15, 4: 0.15, 5: 0.3}


def smooth(exact_motion, arm):
    """A motion without a boundary layer (its first tenth of a second is cut off), and its exact angles."""
    time, torque = np.arange(4) * 0.1, np.full(4, 0.5)
    state = exact_motion(Scenario(arm, time, torque), np.full(arm.links, 0.2))[1]
    start = Pose(state[: arm.links], state[arm.links :])
    scenario = Scenario(arm, time, torque, start)
    return scenario, exact_motion(scenario, start.angles, start.rates, tolerance=1e-12)[:, : arm.links]


@pytest.fixture(scope="module")
def stiff(exact_motion):
    return smooth(exact_motion, ArmSpecification(links=3, mount="horizontal", tip_mass=0.02))


@pytest.fixture(scope="module")
def soft(exact_motion):
    return smooth(exact_motion, ArmSpecification(links=1, mount="horizontal", tip_mass=0.1))


def observed_order(name, motion, step):
    scenario, exact = motion
    coarse, fine = (
        np.abs(simulate(scenario, integrator=name, step=h).trajectory.joint_angles - exact).max() for h in (step, step / 2)
    )
    return np.log2(coarse / fine)


@methods
def test_error_falls_at_the_nominal_order(name, stiff):
    order = INTEGRATORS[name].order
    assert observed_order(name, stiff, 2e-3 if order < 5 else 4e-3) >= order - SLACK[order]


@methods
def test_order_holds_when_springs_and_dampers_are_treated_only_nearly_right(name, soft):
    scenario, exact = soft
    nearly = Scenario(ArmSpecification(links=1, keq=1.3, damping=0.06), scenario.time, scenario.torque)
    order = INTEGRATORS[name].order
    assert observed_order(name, (replace(scenario, implicit_as=nearly), exact), 5e-3) >= order - SLACK[order]


@pytest.mark.parametrize("name", ["extrapolated2", "extrapolated4", "ros2"])
def test_a_law_with_memory_is_followed_to_second_order(name):
    time = np.arange(4) * 0.1
    scenario = Scenario(
        ArmSpecification(links=1, tip_mass=0.1), time, np.full(4, 0.5), Pose([0.2]), effects=(Viscoelastic(0.8, 0.05),)
    )
    exact = simulate(scenario, step=1e-4).trajectory.joint_angles
    assert observed_order(name, (scenario, exact), 1e-2) >= 1.85


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 6])
def test_extrapolation_weights_cancel_the_powers_of_the_step(order):
    method = ExtrapolatedEuler(order)
    lengths = method.lengths(1.0)
    for power in range(order):
        cancelled = sum(w * d**power for w, d in zip(method._weights.flat, lengths, strict=True))
        assert cancelled == pytest.approx(1.0 if power == 0 else 0.0, abs=1e-12 * 6**order)


class Oscillator:
    """One degree of freedom of unit mass with k = (w h)^2 and a damping ratio, in a step of 1, as a Chain."""

    def __init__(self, method, frequency, ratio):
        self.stiffness, self.damping = np.array([[frequency**2]]), np.array([[2 * ratio * frequency]])
        self.work = workspace(method.lengths(1.0), links=1, columns=1)

    def solve(self, first, after, push=0.0):
        q, v, d = self.work[first]
        mass = 1 + d * self.damping + d * d * self.stiffness
        return (push - self.stiffness * q - self.damping * v - d * self.stiffness * v) / mass


def growth(method, frequency, ratio):
    """Factor by which an oscillation can grow in a step: the spectral radius of the method's stability matrix."""
    chain = Oscillator(method, frequency, ratio)
    columns = [np.concatenate(method.advance(chain, np.array([[q]]), np.array([[v]]), 1.0)) for q, v in ((1.0, 0.0), (0.0, 1.0))]
    return np.abs(np.linalg.eigvals(np.hstack(columns))).max()


@pytest.mark.parametrize("ratio", [0.006, 0.1, 1.0, 10.0])
@methods
def test_no_oscillation_damped_by_six_thousandths_grows_at_any_step(name, ratio):
    assert max(growth(INTEGRATORS[name], frequency, ratio) for frequency in np.logspace(-2, 4, 150)) < 1


@pytest.mark.parametrize("name", ["euler", "extrapolated2", "ros2"])
def test_methods_up_to_order_two_are_stable_without_damping(name):
    assert max(growth(INTEGRATORS[name], frequency, 0.0) for frequency in np.logspace(-2, 4, 150)) <= 1 + 1e-12


def check_settling(name, links, stiffnesses):
    """Simulate a step at the default step of time: the motion is bounded, and ends where the arm rests under that torque."""
    moving, resting = [], []
    for keq in stiffnesses:
        arm = ArmSpecification(links=links, keq=keq, damping=default_damping(keq))
        moving.append(step_scenario(arm, 0.9 * keq, rest=0.0, step=0.05))
        resting.append(replace(moving[-1], start=Settled(0.9 * keq)))
    results = simulate_batch([*moving, *resting], integrator=name)
    for run, rest in zip(results[: len(moving)], results[len(moving) :], strict=True):
        assert run.completed
        assert np.abs(run.trajectory.joint_angles.sum(axis=1)).max() < 1.5
        np.testing.assert_allclose(run.trajectory.positions[-1], rest.trajectory.positions[0], rtol=0, atol=1e-4)
        np.testing.assert_allclose(rest.trajectory.positions[-1], rest.trajectory.positions[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("links", [1, 4, 32])
@methods
def test_the_default_step_is_stable_and_settles_at_the_equilibrium(name, links):
    check_settling(name, links, (0.5, 1.11, 2.33, 4.0))


@pytest.mark.long
@pytest.mark.parametrize("links", [128, 500])
@methods
def test_the_default_step_is_stable_for_very_many_links(name, links):
    check_settling(name, links, (0.5, 4.0))


@methods
def test_a_step_takes_as_many_evaluations_of_the_dynamics_for_any_number_of_links(name, monkeypatch):
    calls, original = [], pin.abaInParallel
    monkeypatch.setattr(pin, "abaInParallel", lambda *args: (calls.append(1), original(*args))[1])
    stages = {"euler": 1, "extrapolated2": 3, "extrapolated3": 6, "extrapolated4": 10, "extrapolated5": 15, "ros2": 2}[name]
    for links in (2, 60):
        calls.clear()
        simulate(step_scenario(ArmSpecification(links=links), 0.5, duration=0.1), integrator=name)
        assert len(calls) == 10 * stages


def test_no_dense_matrix_is_made_while_stepping(monkeypatch):
    def refuse(*_):
        raise AssertionError("an O(N^2) algorithm was called")

    for name in ("crba", "computeMinverse", "computeABADerivatives"):
        monkeypatch.setattr(pin, name, refuse)
    assert simulate(step_scenario(ArmSpecification(), 0.5, duration=0.1)).completed


def test_an_unknown_integrator_is_refused_with_those_there_are():
    with pytest.raises(InputError, match=r"expected euler, .*ros2, got 'rk4'"):
        integrator("rk4")


@pytest.mark.parametrize("order", [0, 7])
def test_an_order_out_of_range_is_refused(order):
    with pytest.raises(ValueError, match="order: expected 1 to 6"):
        ExtrapolatedEuler(order)
