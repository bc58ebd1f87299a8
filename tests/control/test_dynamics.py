"""The model functions are the model: against finite differences, the simulation and each other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import EFFECTS, parse_effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.inverse import joint_torques
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

KNOWN = tuple(
    parse_effect(text)
    for text in (
        "torque_decay:decay=0.4",
        "stiffness_gradient:slope=0.5",
        "damping_gradient:slope=-0.6",
        "tip_mass:mass=0.05",
    )
)
MODELS = {
    "nominal": ArmDynamics(ArmSpecification()),
    "one link": ArmDynamics(ArmSpecification(links=1, mount="upright")),
    "known effects": ArmDynamics(ArmSpecification(links=5, placement="mid", tilt=0.3), KNOWN),
}
models = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS.keys())


def somewhere(model, seed=0):
    random = np.random.default_rng(seed)
    return random.normal(0, 0.4, model.links), random.normal(0, 2.0, model.links), 0.7


def differences(function, x, width=1e-6):
    return np.column_stack([(function(x + w) - function(x - w)) / (2 * width) for w in width * np.eye(len(x))])


@models
def test_the_equations_of_motion_balance(model):
    q, v, u = somewhere(model)
    a = model.forward(q, v, u)
    np.testing.assert_allclose(
        model.M(q) @ a + model.C(q, v) @ v + model.G(q), model.b * u - model.K * q - model.D * v, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(model.inverse(q, v, a), model.b * u, rtol=0, atol=1e-12)
    assert model.uniform(model.b * u) == pytest.approx(u)


@models
def test_coriolis_terms_are_those_that_conserve_energy(model):
    q, v, _ = somewhere(model)
    rate = (model.M(q + 1e-6 * v) - model.M(q - 1e-6 * v)) / 2e-6
    skew = rate - 2 * model.C(q, v)
    np.testing.assert_allclose(skew, -skew.T, rtol=0, atol=1e-9)


@pytest.mark.parametrize("effects", [(), KNOWN], ids=["nominal", "known effects"])
def test_inverse_dynamics_are_those_of_the_simulation(effects):
    arm = ArmSpecification(links=5, tilt=0.3)
    model = ArmDynamics(arm, effects)
    q, v, _ = somewhere(model)
    a = np.arange(5.0)
    np.testing.assert_allclose(model.inverse(q, v, a), joint_torques(arm, [q], [v], [a], effects)[0], rtol=0, atol=1e-12)


@models
@pytest.mark.parametrize("moving", [False, True])
def test_the_linearisation_is_what_finite_differences_give(model, moving):
    q, v, u = somewhere(model)
    v = v if moving else None
    linear, n = model.linearise(q, u, v), model.links
    x = np.concatenate([q, np.zeros(n) if v is None else v])

    def rate(x, u=u):
        return np.concatenate([x[n:], model.forward(x[:n], x[n:], u)])

    scale = np.abs(linear.A).max()
    np.testing.assert_allclose(linear.A, differences(rate, x), rtol=0, atol=1e-6 * scale)
    np.testing.assert_allclose(linear.A[n:, :n], differences(rate, x)[n:, :n], rtol=1e-6, atol=1e-8 * scale)
    np.testing.assert_allclose(linear.B[:, 0], (rate(x, u + 0.1) - rate(x, u - 0.1)) / 0.2, rtol=1e-9, atol=1e-9 * scale)
    np.testing.assert_allclose(linear.joints @ model.b, linear.B[:, 0], rtol=1e-12)
    np.testing.assert_allclose(linear.rate, rate(x), rtol=1e-9, atol=1e-9)


def test_the_discrete_linearisation_is_the_exact_flow_of_the_continuous_one():
    model = ArmDynamics(ArmSpecification(links=2))
    q, v, u = somewhere(model)
    linear = model.linearise(q, u, v)
    step = linear.discrete(0.01)
    start, push = np.array([0.01, -0.02, 0.3, -0.1]), 0.2
    flow = solve_ivp(
        lambda t, x: linear.A @ x + linear.B[:, 0] * push + linear.rate, (0, 0.01), start, "Radau", rtol=1e-11, atol=1e-13
    )
    np.testing.assert_allclose(step.A @ start + step.B[:, 0] * push + step.rate, flow.y[:, -1], rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(step.joints @ model.b, step.B[:, 0], rtol=1e-9)


def test_the_discrete_linearisation_is_the_simulation_of_small_motions():
    arm = ArmSpecification()
    model, simulator = ArmDynamics(arm), ArmSimulator(arm, step=5e-4)
    rest = simulator.reset(0.5)
    linear = model.linearise(rest.angles, 0.5).discrete(0.02)
    after = simulator.advance(rest, 0.5 + 1e-4, 0.02)
    moved = np.concatenate([after.angles - rest.angles, after.rates - rest.rates]) / 1e-4
    np.testing.assert_allclose(linear.B[:, 0], moved, rtol=0, atol=2e-3 * np.abs(moved).max())


@models
def test_the_tip_jacobian_is_what_finite_differences_give(model):
    q, _, _ = somewhere(model)
    np.testing.assert_allclose(model.tip_jacobian(q), differences(model.tip, q), rtol=0, atol=1e-9)


def test_a_motion_goes_back_to_its_torque_and_forward_to_itself_to_the_integrators_order():
    arm = ArmSpecification(links=4, placement="mid", mount="horizontal", tip_mass=0.05)
    model, fine, held = ArmDynamics(arm), 5e-4, 0.1
    time = np.arange(round(0.6 / fine) + 1) * fine
    torque = 0.5 + 0.3 * np.sin(4 * held * np.floor(time / held + 1e-6))
    run = simulate(Scenario(arm, time, torque, Settled(0.4)), step=fine).trajectory
    q, v = run.joint_angles, run.joint_rates
    a = (v[:-4] - 8 * v[1:-3] + 8 * v[3:-1] - v[4:]) / (12 * fine)  # of samples 2 to -3
    late = np.arange(1, 7) * round(held / fine) - 10  # near the end of each hold, where the jump has died away
    found = np.array([model.uniform(model.inverse(q[k], v[k], a[k - 2])) for k in late])
    np.testing.assert_allclose(found, torque[late], rtol=0, atol=1e-7)
    errors = []
    for step in (0.01, 0.005):
        simulator = ArmSimulator(arm, step=step)
        simulator.reset(0.4)
        for u in found:
            simulator.step(u, dt=held)
        errors.append(np.abs(simulator.state.angles - q[-1]).max())
    assert errors[0] < 1e-4
    assert np.log2(errors[0] / errors[1]) > 3.4


@pytest.mark.parametrize("name", ["hysteresis", "dead_time", "stiffening", "marker_offset"])
def test_an_effect_that_is_no_part_of_a_linear_model_is_refused(name):
    law = EFFECTS[name]
    with pytest.raises(InputError, match=name):
        ArmDynamics(ArmSpecification(), [law()])


@pytest.mark.parametrize("q", [np.zeros(3), np.full(4, np.nan), 0.0])
def test_a_pose_that_is_none_is_refused(q):
    with pytest.raises(InputError, match="q: expected 4 finite numbers"):
        MODELS["nominal"].M(q)
