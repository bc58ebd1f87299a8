"""Each method converges at its order, stays stable where explicit ones do not, and costs O(N) a step."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects.viscoelastic import Viscoelastic
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification, default_damping
from hsr_pin.simulation import integrate
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_batch, simulate_together
from hsr_pin.simulation.integrator import ORDERS, Integrator
from hsr_pin.simulation.reference import PinocchioSystem
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate

methods = pytest.mark.parametrize("name", ORDERS)

#: How far a measured order may stay behind, and the step [s] it is measured at: beyond order 4 rounding forbids shorter ones.
SLACK = {1: 0.15, 2: 0.15, 3: 0.15, 4: 0.15, 5: 0.3, 6: 0.8}
STIFF_STEP = {1: 2e-3, 2: 2e-3, 3: 2e-3, 4: 2e-3, 5: 4e-3, 6: 1e-2}
SOFT_STEP = {1: 5e-3, 2: 5e-3, 3: 5e-3, 4: 5e-3, 5: 5e-3, 6: 2e-2}


def smooth(exact_motion, arm):
    """A motion without a boundary layer (its first tenth of a second is cut off), and its exact angles and rates."""
    time, torque = np.arange(4) * 0.1, np.full(4, 0.5)
    state = exact_motion(Scenario(arm, time, torque), np.full(arm.links, 0.2))[1]
    start = Pose(state[: arm.links], state[arm.links :])
    scenario = Scenario(arm, time, torque, start)
    return scenario, exact_motion(scenario, start.angles, start.rates, tolerance=1e-12)


@pytest.fixture(scope="module")
def stiff(exact_motion):
    return smooth(exact_motion, ArmSpecification(links=3, mount="horizontal", tip_mass=0.02))


@pytest.fixture(scope="module")
def soft(exact_motion):
    return smooth(exact_motion, ArmSpecification(links=1, mount="horizontal", tip_mass=0.1))


def run(scenario, name, step, implicit=1.0):
    """(S, 2N) angles and rates, springs and dampers treated as if they were ``implicit`` times as strong."""
    batch = ArmBatch.of([scenario])
    arrays = batch.arrays
    batch.__dict__["arrays"] = arrays._replace(stiff=implicit * arrays.stiff, drag=implicit * arrays.drag)
    motion = simulate_together([scenario], batch, Integrator(name, step=step), "compiled")
    return np.concatenate([motion.angles[:, 0], motion.rates[:, 0]], axis=1)


def observed_order(name, motion, step, **how):
    scenario, exact = motion
    columns = exact.shape[1]  # angles alone, or rates too
    coarse, fine = (np.abs(run(scenario, name, h, **how)[:, :columns] - exact).max() for h in (step, step / 2))
    return np.log2(coarse / fine)


@methods
def test_error_falls_at_the_nominal_order(name, stiff):
    order, (scenario, exact) = ORDERS[name], stiff
    assert observed_order(name, (scenario, exact[:, :3]), STIFF_STEP[order]) >= order - SLACK[order]


@methods
@pytest.mark.parametrize("implicit", [0.7, 1.0, 1.3])
def test_order_holds_when_springs_and_dampers_are_treated_only_nearly_right(name, implicit, soft):
    order = ORDERS[name]
    assert observed_order(name, soft, SOFT_STEP[order], implicit=implicit) >= order - SLACK[order]


@pytest.mark.parametrize("name", ["extrapolated2", "extrapolated4"])
def test_a_law_with_memory_is_followed_to_second_order(name):
    time = np.arange(4) * 0.1
    scenario = Scenario(
        ArmSpecification(links=1, tip_mass=0.1), time, np.full(4, 0.5), Pose([0.2]), effects=(Viscoelastic(0.8, 0.05),)
    )
    assert observed_order(name, (scenario, run(scenario, name, 1e-4)), 1e-2) >= 1.85


@methods
def test_samples_between_steps_are_as_good_as_those_at_their_ends(name, soft):
    """Samples every sixtieth of a step; the cubic between is of order 4, with far smaller an error than any step's."""
    scenario, _ = soft
    order = ORDERS[name]
    inside, at_ends = [], []
    for step in (0.02, 0.01):
        fine = replace(scenario, time=np.linspace(0, 0.3, 3601), torque=np.full(3601, 0.5))
        exact = simulate_batch([fine], integrator="extrapolated6", step=1e-3)[0].trajectory.joint_angles
        sparse = replace(scenario, time=np.arange(round(0.3 / step) + 1) * step, torque=np.full(round(0.3 / step) + 1, 0.5))
        each = round(3600 * step / 0.3)
        batch = ArmBatch.of([sparse])
        errors = np.abs(between_samples(batch, sparse, name, each) - exact).max(axis=1)
        inside.append(errors.max())
        at_ends.append(errors[::each].max())
    assert np.log2(inside[0] / inside[1]) >= min(order, 4) - 0.3
    assert inside[1] <= max(1.5 * at_ends[1], 1e-6)


def between_samples(batch, scenario, name, each):
    """(S, N) angles by steps of a cell of ``each`` samples."""
    cells, first = len(scenario.time) - 1, scenario.start
    q, v, z = first.angles[None].copy(), first.rates[None].copy(), np.zeros((0, 1, batch.links))
    impulse = 0.5 * each * np.arange(cells * each + 1.0)[None] / each
    angles, rates = np.zeros((2, cells * each + 1, 1, batch.links))
    integrate.integrate(
        batch.pinocchio("aba"), q, v, z, impulse, scenario.step / each, 1, np.arange(cells * each + 1.0) // each * each + each,
        Integrator(name, step=1.0).weights, np.inf, float(each), float(each), np.full(1, np.inf), angles, rates,
        np.full(1, np.inf), np.zeros(cells), np.zeros((1, batch.links)),
    )  # fmt: skip
    return angles[:, 0]


@methods
def test_extrapolation_weights_cancel_the_powers_of_the_step(name):
    order = ORDERS[name]
    for weights, terms in zip(Integrator(name, step=1.0).weights, (order, order - 1), strict=True):
        for power in range(terms):
            cancelled = weights @ (1.0 / np.arange(1, order + 1)) ** power
            assert cancelled == pytest.approx(1.0 if power == 0 else 0.0, abs=1e-12 * 6**order)


def growth(name, frequencies, ratio):
    """Largest factor by which an oscillation of unit mass, k = (w h)^2 and a damping ratio, can grow in a step of 1."""
    model = pin.Model()
    model.gravity = pin.Motion.Zero()
    model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "x")
    model.appendBodyToJoint(1, pin.Inertia(1.0, np.zeros(3), np.zeros((3, 3))), pin.SE3.Identity())
    count = len(frequencies)
    spring, damper = frequencies[:, None] ** 2, 2 * ratio * frequencies[:, None]
    joints = {"share": np.zeros((count, 1)), "spring": spring, "stiff": spring, "damper": damper, "drag": damper}
    arrays = SimpleNamespace(**joints, world=np.zeros((count, 0, 1)))
    system = PinocchioSystem(arrays, (model,) * count, (model.createData(),) * count, (), "aba")
    columns = []
    for start in ((1.0, 0.0), (0.0, 1.0)):
        q, v = (np.full((count, 1), x) for x in start)
        work, z, torque = np.zeros((7, count, 1)), np.zeros((0, count, 1)), np.zeros(count)
        weights = Integrator(name, step=1.0).weights
        integrate.extrapolate(
            system, q, v, z, np.zeros((count, 2)), 0.0, 1.0, 1.0, weights, work, z, torque, np.zeros((integrate.ROWS, 1))
        )
        columns.append(work[:2, :, 0].T)
    return np.abs(np.linalg.eigvals(np.stack(columns, axis=-1))).max()


@pytest.mark.parametrize("ratio", [0.006, 0.1, 1.0, 10.0])
@methods
def test_no_oscillation_damped_by_six_thousandths_grows_at_any_step(name, ratio):
    assert growth(name, np.logspace(-2, 4, 150), ratio) < 1


@pytest.mark.parametrize("name", ["euler", "extrapolated2"])
def test_methods_up_to_order_two_are_stable_without_damping(name):
    assert growth(name, np.logspace(-2, 4, 150), 0.0) <= 1 + 1e-12


def check_settling(links, stiffnesses, **how):
    """Simulate a step: the motion is bounded, and ends where the arm rests under that torque."""
    moving, resting = [], []
    for keq in stiffnesses:
        arm = ArmSpecification(links=links, keq=keq, damping=default_damping(keq))
        moving.append(step_scenario(arm, 0.9 * keq, rest=0.0, step=0.05))
        resting.append(replace(moving[-1], start=Settled(0.9 * keq)))
    results = simulate_batch([*moving, *resting], **how)
    for run, rest in zip(results[: len(moving)], results[len(moving) :], strict=True):
        assert run.completed
        assert np.abs(run.trajectory.joint_angles.sum(axis=1)).max() < 1.5
        np.testing.assert_allclose(run.trajectory.positions[-1], rest.trajectory.positions[0], rtol=0, atol=1e-4)
        np.testing.assert_allclose(rest.trajectory.positions[-1], rest.trajectory.positions[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("links", [1, 4, 32, 128])
@methods
def test_steps_of_a_hundredth_of_a_second_are_stable_and_settle_at_the_equilibrium(name, links):
    check_settling(links, (0.5, 1.11, 2.33, 4.0), integrator=name, step=0.01)


@pytest.mark.parametrize("links", [1, 4, 32, 128, 500])
@pytest.mark.parametrize("name", [name for name in ORDERS if name != "euler"])
def test_steps_as_long_as_the_motion_allows_settle_at_the_equilibrium(name, links):
    check_settling(links, (0.5, 4.0), integrator=name)


@pytest.mark.long
@methods
def test_long_steps_are_stable_for_very_many_links(name):
    check_settling(500, (0.5, 4.0), integrator=name, step=0.01)


@methods
def test_a_step_takes_as_many_evaluations_of_the_dynamics_for_any_number_of_links(name, monkeypatch):
    calls, original = [], pin.aba
    monkeypatch.setattr(pin, "aba", lambda *args: (calls.append(1), original(*args))[1])
    for links in (2, 60):
        calls.clear()
        simulate(step_scenario(ArmSpecification(links=links), 0.5, duration=0.1), integrator=name, step=0.01)
        assert len(calls) == 10 * ORDERS[name] * (ORDERS[name] + 1) / 2


def test_no_dense_matrix_is_made_while_stepping(monkeypatch):
    def refuse(*_):
        raise AssertionError("an O(N^2) algorithm was called")

    for name in ("crba", "computeMinverse", "computeABADerivatives"):
        monkeypatch.setattr(pin, name, refuse)
    assert simulate(step_scenario(ArmSpecification(), 0.5, duration=0.1)).completed


@pytest.mark.parametrize(
    ("how", "complaint"),
    [
        ({"integrator": "rk4"}, "integrator: expected euler, .*extrapolated6, got 'rk4'"),
        ({"integrator": "euler"}, "step: expected a step length"),
        ({"step": 0}, "step: expected a number above zero, got 0"),
        ({"step": np.nan}, "step: expected a number above zero, got nan"),
        ({"step": "fast"}, "step: expected a number above zero, got 'fast'"),
        ({"tolerance": -1e-5}, "tolerance: expected a number above zero, got -1e-05"),
        ({"tolerance": np.inf}, "tolerance: expected a number above zero, got inf"),
    ],
)
def test_what_no_method_can_do_is_refused(how, complaint):
    with pytest.raises(InputError, match=complaint):
        simulate(step_scenario(ArmSpecification(), 0.5, duration=0.1), **how)
