"""Inverse dynamics gives back the torque that made a motion."""

import numpy as np
import pytest

from hsr_pin.effects.damping_gradient import DampingGradient
from hsr_pin.effects.effect import Effect
from hsr_pin.effects.hysteresis import Hysteresis
from hsr_pin.effects.quadratic_damping import QuadraticDamping
from hsr_pin.errors import InputError
from hsr_pin.robot.pressure import PressureMap
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.columns import Columns, shape_of
from hsr_pin.simulation.forward import forward_dynamics
from hsr_pin.simulation.inverse import joint_torques, required_pressures, required_torque
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

ARM = ArmSpecification(links=4, placement="mid", mount="horizontal", tip_mass=0.05)
EFFECTS = (DampingGradient(0.5), QuadraticDamping(0.01))


class HalfAtTheTip(Effect):
    name = "half_at_the_tip"

    def actuation(self, s):
        return 1 - s / 2


def smooth_motion(step, effects=()):
    """q, v, a at the samples, and the torque there: 0.6 + 0.3 sin^2 t, held at its mean over each step."""

    def integral(t):
        return 0.75 * t - 0.075 * np.sin(2 * t)

    time = np.arange(round(0.5 / step) + 1) * step
    held = np.diff(integral(np.append(time, time[-1] + step))) / step
    motion = simulate(Scenario(ARM, time, held, Settled(0.6), effects), step=step).trajectory
    acceleration = (motion.joint_rates[2:] - motion.joint_rates[:-2]) / (2 * step)
    return motion.joint_angles[1:-1], motion.joint_rates[1:-1], acceleration, 0.6 + 0.3 * np.sin(time[1:-1]) ** 2


@pytest.mark.parametrize("effects", [(), EFFECTS, (HalfAtTheTip(),)], ids=["nominal", "effects", "uneven"])
def test_the_torque_that_made_a_motion_comes_back_at_second_order(effects):
    errors = []
    for step in (2e-3, 1e-3):
        *motion, torque = smooth_motion(step, effects)
        errors.append(np.abs(required_torque(ARM, *motion, effects).torque - torque)[round(0.1 / step) :].max())
    assert errors[1] < 2e-5
    assert np.log2(errors[0] / errors[1]) >= 1.85


def test_inverse_dynamics_undoes_forward_dynamics():
    random = np.random.default_rng(0)
    q, v, tau = (np.asfortranarray(random.normal(0, size, (4, 6))) for size in (0.5, 3.0, 1.0))
    scenarios = [Scenario(ARM, [0.0, 1.0], [0.0, 0.0], effects=EFFECTS)] * 6
    columns = Columns(scenarios, shape_of(scenarios[0], 1.0))
    forward = forward_dynamics("aba", [arm.model for arm in columns.arm_models], [np.zeros(4)])
    a = forward.solve(0, q, v, columns.torque(q, v, columns.virgin_states()) + tau)
    np.testing.assert_allclose(joint_torques(ARM, q.T, v.T, a.T, EFFECTS).T, tau, rtol=0, atol=1e-11)


def test_what_no_uniform_torque_can_deliver_is_left_over():
    rest = np.zeros((1, 4))
    extra = np.array([[0.3, -0.1, -0.3, 0.1]])  # sums to nothing
    bent = extra / ARM.joint_stiffness
    required = required_torque(ARM, bent, rest, rest)
    np.testing.assert_allclose(required.torque[:, None] + required.residual, joint_torques(ARM, bent, rest, rest), atol=1e-14)
    assert required.residual.sum() == pytest.approx(0.0, abs=1e-14)
    assert np.abs(required.residual).max() > 0.1


def test_the_pressures_of_a_settled_arm_are_those_of_its_torque():
    motion = simulate(Scenario(ARM, [0.0, 0.01], [0.8, 0.8], Settled(0.8))).trajectory
    still = np.zeros((1, 4))
    pressures = required_pressures(ARM, motion.joint_angles[:1], still, still)
    np.testing.assert_allclose(pressures, [PressureMap.fit().pressures_for_torque(ARM.keq, 0.8)], atol=1e-9)


def test_an_effect_with_memory_is_refused():
    with pytest.raises(InputError, match="hysteresis"):
        joint_torques(ARM, *np.zeros((3, 5, 4)), effects=(Hysteresis(0.1),))


@pytest.mark.parametrize("shape", [(4,), (5, 3)])
def test_angles_of_another_shape_are_refused(shape):
    with pytest.raises(InputError, match=r"q: expected finite values \(T, 4\)"):
        joint_torques(ARM, np.zeros(shape), np.zeros((5, 4)), np.zeros((5, 4)))
