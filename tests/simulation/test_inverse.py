"""Inverse dynamics gives back the torque that made a motion."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.effects.damping_gradient import DampingGradient
from hsr_pin.effects.effect import Effect
from hsr_pin.effects.hysteresis import Hysteresis
from hsr_pin.effects.obstacle import Obstacle
from hsr_pin.effects.quadratic_damping import QuadraticDamping
from hsr_pin.effects.stiffening import Stiffening
from hsr_pin.errors import InputError
from hsr_pin.obstacles import HalfSpace
from hsr_pin.robot.pressure import PressureMap
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation import kernel
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.inverse import joint_torques, required_pressures, required_torque
from hsr_pin.simulation.reference import add_joint_moments
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

ARM = ArmSpecification(links=4, placement="mid", mount="horizontal", tip_mass=0.05)
EFFECTS = (DampingGradient(0.5), Stiffening(0.2))


class HalfAtTheTip(Effect):
    name = "half_at_the_tip"

    def actuation(self, s):
        return 1 - s / 2


def motion_of(scenario):
    """q, v, a two samples and more from the ends; a by differences of order 4."""
    run = simulate(scenario, step=scenario.step).trajectory
    v = run.joint_rates
    a = (v[:-4] - 8 * v[1:-3] + 8 * v[3:-1] - v[4:]) / (12 * scenario.step)
    return run.joint_angles[2:-2], v[2:-2], a


effects = pytest.mark.parametrize("effects", [(), EFFECTS, (HalfAtTheTip(),)], ids=["nominal", "effects", "uneven"])


@effects
def test_the_torque_that_made_a_motion_comes_back_to_the_integrators_order(effects):
    errors = []  # of the integrator and of the differences, both of order 4
    for step in (4e-3, 2e-3):
        time = np.arange(round(0.6 / step) + 1) * step
        motion = motion_of(Scenario(ARM, time, np.full(len(time), 0.9), Settled(0.4), effects))
        late = round(0.3 / step)  # the boundary layer of the release is over
        errors.append(np.abs(required_torque(ARM, *motion, effects).torque[late:] - 0.9).max())
    assert errors[1] < 1e-8
    assert np.log2(errors[0] / errors[1]) >= 3.4


@effects
def test_a_torque_that_varies_comes_back_as_a_function_of_time(effects):
    time = np.arange(301) * 2e-3
    wave = 0.6 + 0.3 * np.sin(3 * time)
    motion = motion_of(Scenario(ARM, time - 1e-3, wave, Settled(0.6), effects))  # held from half a step before to half after
    found = required_torque(ARM, *motion, effects).torque
    np.testing.assert_allclose(found[50:], (0.6 + 0.3 * np.sin(3 * (time - 1e-3)))[52:-2], rtol=0, atol=1e-3)


def test_inverse_dynamics_undoes_forward_dynamics():
    laws = (*EFFECTS, QuadraticDamping(0.01))
    random = np.random.default_rng(0)
    q, v = (random.normal(0, size, (6, 4)) for size in (0.5, 3.0))
    torque = random.normal(0, 1.0, 6)
    batch = ArmBatch.of([Scenario(ARM, [0.0, 1.0], [0.0, 0.0], effects=laws)] * 6)
    batch.__dict__["arrays"] = batch.arrays._replace(stiff=0 * q, drag=0 * q)  # a plain step of length 1
    moment, after = np.zeros_like(q), v.copy()
    add_joint_moments(batch.pinocchio("aba"), q, v, np.zeros((0, 6, 4)), moment)
    kernel.substep(batch.arrays, q.copy(), after, moment[None][:0], moment, torque, 1.0, np.zeros((kernel.SCRATCH, 4)))
    found = joint_torques(ARM, q, v, after - v, laws)
    np.testing.assert_allclose(found, np.repeat(torque[:, None], 4, axis=1), rtol=0, atol=1e-11)


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


@pytest.mark.parametrize("beside", [{"obstacles": (HalfSpace(),)}, {}])
def test_an_arm_with_obstacles_has_no_inverse(beside):
    effects = () if beside else (Obstacle(hardness=1e4),)
    with pytest.raises(InputError, match=r"obstacles: expected none for inverse dynamics"):
        joint_torques(replace(ARM, **beside), *np.zeros((3, 2, ARM.links)), effects)
