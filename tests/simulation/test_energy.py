"""Nothing gains energy from nowhere, and what does is told."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.effects.effect import Bending
from hsr_pin.errors import InputError, SimulationFailure
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.energy import energy
from hsr_pin.simulation.result import Outcome, SimulationResult
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Trajectory

TIME = np.arange(1001) * 0.01
#: Elastic and dissipative laws, whose stored energy the motion tells.
LAWS = ["", "", "", "stiffening:cubic=1", "backlash:gap=0.2", "bending_stop:ratio=8,angle=0.4", "soft_spot:depth=0.7"]
LAWS += ["quadratic_damping:coefficient=0.01", "preset_bend:angle=0.4", "stiffness_gradient:slope=1"]


def arm_of(generator):
    """Any passive arm: two in three are hardly damped, or not at all."""
    damping = float(generator.choice([0.0, 10 ** generator.uniform(-6, -3), 10 ** generator.uniform(-3, -1)]))
    return ArmSpecification(
        links=int(generator.integers(1, 13)),
        placement=str(generator.choice(["base", "mid"])),
        mount=str(generator.choice(["hanging", "upright", "horizontal"])),
        keq=generator.uniform(0.5, 3),
        damping=damping,
        tip_mass=float(generator.choice([0.0, 0.05, 0.2])),
        bending_limit=20.0,
    )


def free_runs(count, seed):
    """Arms that are let go, or driven by one step of torque, for 5 s."""
    generator, runs = np.random.default_rng(seed), []
    for _ in range(count):
        arm, text = arm_of(generator), str(generator.choice(LAWS))
        effects = (parse_effect(text),) if text else ()
        step = float(generator.choice([0.005, 0.01, 0.02]))
        time = np.arange(round(5 / step) + 1) * step
        let_go = Pose(generator.normal(0, 0.5, arm.links) / np.sqrt(arm.links))
        torque = np.where(time < 0.1, 0.0, generator.uniform(-0.6, 0.6))
        driven = generator.random() < 0.5
        runs.append(Scenario(arm, time, torque if driven else 0 * time, Settled() if driven else let_go, effects))
    return runs


def gains(runs, **how):
    """Largest share of its energy that each run gained."""
    return np.array([result.energy().rise for result in simulate_batch(runs, **how)])


def test_energies_are_those_of_pinocchio():
    arm = ArmSpecification(links=5, placement="mid", mount="horizontal", tip_mass=0.05, tilt=0.2)
    q, v = np.random.default_rng(0).normal(size=(2, 20, 5))
    motion = Trajectory(TIME[:20], (), np.zeros((20, 0, 3)), joint_angles=q, joint_rates=v)
    found = energy(Scenario(arm, TIME[:20], np.full(20, 0.3)), motion)
    model = build_model(arm).model
    data = model.createData()
    kinetic = [pin.computeKineticEnergy(model, data, *row) for row in zip(q, v, strict=True)]
    gravity = np.array([pin.computePotentialEnergy(model, data, row) for row in q])
    springs = arm.joint_stiffness * (q**2).sum(axis=1) / 2
    np.testing.assert_allclose(found.kinetic, kinetic, rtol=1e-12)
    np.testing.assert_allclose(np.diff(found.stored), np.diff(gravity + springs), rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.work, 0.3 * (q - q[0]).sum(axis=1), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "stiffening:cubic=2",
        "bending_stop:ratio=8,angle=0.3",
        "backlash:gap=0.3",
        "preset_bend:angle=0.3",
        "partial_bias:bias=0.2,start=0.6",
    ],
)
def test_what_an_elastic_law_stores_is_its_moment_along_the_way(text):
    law, scale = parse_effect(text), np.linspace(0, 1, 20001)
    pose = np.array([0.3, -0.1, 0.2])
    q = scale[:, None] * pose
    motion = Trajectory(scale, (), np.zeros((len(scale), 0, 3)), joint_angles=q, joint_rates=0 * q)
    arm = ArmSpecification(links=3)
    stored = [energy(Scenario(arm, scale, 0 * scale, effects=laws), motion).stored for laws in ((law,), ())]
    moment = law.moment(law.p, Bending(3 * q, 0 * q, arm.keq, 1.0, np.array([1, 3, 5]) / 6, ())) @ pose
    work = np.append(0.0, np.cumsum((moment[1:] + moment[:-1]) / 2 * np.diff(scale)))
    np.testing.assert_allclose(stored[0] - stored[1], work, rtol=0, atol=2e-3 * np.abs(work).max())


def test_passive_arms_gain_no_energy():
    assert gains(free_runs(40, seed=1)).max() < 0.05


@pytest.mark.long
def test_four_hundred_passive_arms_gain_no_energy():
    assert gains(free_runs(400, seed=2)).max() < 0.05


def test_the_method_for_other_arms_would_add_energy_to_those_that_ring():
    """The check can fail: a third of the hardly damped arms would gain more than a twentieth."""
    ringing = [run for run in free_runs(60, seed=1) if run.arm.damping < 1e-3 and not run.effects]
    assert np.mean(gains(ringing, integrator="extrapolated4") > 0.05) > 0.3
    assert gains(ringing).max() < 0.05


UNDAMPED = step_scenario(ArmSpecification(links=6, damping=0.0, placement="mid"), 0.5, duration=10)


def test_a_gain_is_told_in_the_result():
    (told,), (good,) = simulate_batch([UNDAMPED], integrator="extrapolated4"), simulate_batch([UNDAMPED])
    assert "integration errors added" in told.warning
    assert good.warning == ""


def test_a_failure_by_a_gain_is_not_blamed_on_the_limit_alone():
    tight = replace(
        UNDAMPED, arm=replace(UNDAMPED.arm, bending_limit=1.3), time=np.arange(6001) * 0.01, torque=np.full(6001, 0.5)
    )
    with pytest.raises(SimulationFailure, match=r"beyond its limit.*integration errors added \d+ % to the energy"):
        simulate(tight, dynamics="compiled", integrator="extrapolated4")
    assert simulate(tight, dynamics="compiled").completed


@pytest.mark.parametrize("damping", [0.05, 1e-3, 0.0])
def test_a_usual_run_is_not_warned_of(damping):
    for torque in (0.0, 0.4, -1.0):
        for effects in ((), (parse_effect("stiffening:cubic=0.5"),), (parse_effect("torque_bias:bias=0.1"),)):
            scenario = step_scenario(ArmSpecification(damping=damping, bending_limit=9.0), torque, effects=effects)
            assert simulate(scenario, dynamics="compiled").warning == ""


@pytest.mark.parametrize("text", ["dry_friction:level=0.1", "actuator_lag:time_constant=0.1", "dead_time:delay=0.1"])
def test_what_an_effect_with_memory_stores_is_not_guessed(text):
    result = simulate(step_scenario(ArmSpecification(), 0.5, duration=0.5, effects=(parse_effect(text),)))
    assert result.warning == ""
    with pytest.raises(InputError, match=f"energy: expected effects without memory.*{text.split(':')[0]}"):
        result.energy()


def test_an_arm_that_does_not_move_gains_nothing():
    motion = simulate(step_scenario(ArmSpecification(), 0.0, duration=0.5))
    assert motion.warning == ""
    one = Trajectory(TIME[:1], (), np.zeros((1, 0, 3)), joint_angles=np.zeros((1, 4)), joint_rates=np.zeros((1, 4)))
    assert SimulationResult(motion.scenario, one, Outcome.NO_EQUILIBRIUM, 0.0, 1).warning == ""
