"""Closed loops follow a tip reference better than open loop, by a stated factor, where an effect is unknown to the controller."""

import numpy as np
import pytest

from hsr_pin.control.controllers import LQR, ComputedTorque, FeedforwardPD, OpenLoop, lqr_gain
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reach import rest_under, static_pose
from hsr_pin.control.reference import reference_from_torque, reference_through_tips
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification

ARM = ArmSpecification()
MODEL = ArmDynamics(ARM)
REFERENCE = reference_through_tips(MODEL, [rest_under(MODEL, u).tip for u in (0.0, 0.9, -0.4)], (-1.2, 1.2), move=0.5, hold=0.3)
LAWS = {
    "feedforward and PD": FeedforwardPD(MODEL, REFERENCE, kp=5.0, kd=0.05),
    "computed torque": ComputedTorque(MODEL, REFERENCE, frequency=80.0),
    "LQR": LQR(REFERENCE, lqr_gain(MODEL, 0.0, REFERENCE.step)),
}
laws = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def error(law, *effects, reference=REFERENCE, noise=True):
    """RMS distance [m] of the tip from the reference, with noisy angles [rad] and rates [rad/s]."""
    random, simulator = np.random.default_rng(3), ArmSimulator(ARM, effects)
    squares = []
    for k in range(len(reference.time) - 1):
        q = simulator.state.angles + noise * random.normal(0, 2e-3, ARM.links)
        v = simulator.state.rates + noise * random.normal(0, 2e-2, ARM.links)
        state = simulator.step(law.torque(k, q, v), dt=reference.step)
        squares.append(np.sum((MODEL.tip(state.angles) - reference.tip[k + 1]) ** 2))
    return np.sqrt(np.mean(squares))


@laws
@pytest.mark.parametrize(
    ("text", "factor"),
    [
        ("hysteresis:amplitude=0.15", 2.5),
        ("dry_friction:level=0.08", 2.5),
        ("viscoelastic:ratio=0.4", 2.5),
        ("torque_bias:bias=0.15", 2.5),
        ("torque_decay:decay=0.3", 1.8),
        ("actuator_lag:time_constant=0.03", 2.0),
        ("stiffening:cubic=0.4", 2.0),
    ],
)
def test_a_closed_loop_is_nearer_to_the_reference_by_this_factor(law, text, factor):
    effect = parse_effect(text)
    assert error(law, effect) < error(OpenLoop(REFERENCE), effect) / factor


@laws
def test_a_closed_loop_is_within_a_millimetre_where_the_model_is_right(law):
    assert error(law) < 1e-3
    assert error(law, noise=False) < 1e-3


def test_computed_torque_lets_an_error_vanish_with_its_frequency():
    """Away from rest by a push, with the exact model and a fast loop: the error of the whole arm goes as (1 + w t) exp(-w t)."""
    time = np.arange(1001) * 1e-3
    reference = reference_from_torque(MODEL, time, np.full(len(time), 0.5))
    law, simulator = ComputedTorque(MODEL, reference, frequency=10.0), ArmSimulator(ARM, step=1e-3)
    simulator.reset(0.6)
    start = simulator.state.angles.sum() - reference.q[0].sum()
    errors = []
    for k in range(400):
        state = simulator.step(law.torque(k, simulator.state.angles, simulator.state.rates), dt=1e-3)
        errors.append((state.angles.sum() - reference.q[0].sum()) / start)
    t = time[1:401]
    np.testing.assert_allclose(errors, (1 + 10 * t) * np.exp(-10 * t), rtol=0, atol=0.03)


@pytest.mark.parametrize("torque", [0.0, 0.8])
def test_the_lqr_gain_makes_the_sampled_arm_stable_and_is_the_best_about_its_pose(torque):
    gain = lqr_gain(MODEL, torque, 0.01)
    q = static_pose(MODEL, torque)
    linear = MODEL.linearise(q, torque).discrete(0.01)
    J = np.hstack([MODEL.tip_jacobian(q), np.zeros((3, 4))]) / 2e-3

    def cost(gain):
        closed = linear.A - linear.B @ gain[None]
        x, total = np.array([0.02, 0.02, 0.02, 0.02, 0, 0, 0, 0]), 0.0
        for _ in range(300):
            total += np.sum((J @ x) ** 2) + (gain @ x / 0.1) ** 2
            x = closed @ x
        return total

    assert np.abs(np.linalg.eigvals(linear.A - linear.B @ gain[None])).max() < 1
    random = np.random.default_rng(0)
    assert all(cost(gain) < cost(gain * (1 + random.normal(0, 0.05, 8))) for _ in range(20))


def test_weights_that_are_none_are_refused():
    with pytest.raises(InputError, match="lqr"):
        lqr_gain(MODEL, 0.0, 0.01, tip_error=0.0)
