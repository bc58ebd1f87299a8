"""The MuJoCo plant agrees with closed forms of a clamped rod, converges, and loses energy to its dampers only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

from hsr_pin.blind.plants.arm import Arm
from hsr_pin.blind.plants.chain import Chain, ChainPlant
from hsr_pin.blind.plants.integration import Integration, planar
from hsr_pin.blind.plants.laws.law import Joints
from hsr_pin.blind.plants.program import Trial, program
from hsr_pin.errors import SimulationFailure

from .motions import tip_rms

KEQ, C = 1.11, 0.05
WEIGHTLESS = Arm(g=0.0)


def constant(tau: float, duration: float = 0.0) -> Trial:
    return Trial(KEQ, C, duration, (tau,) * (round(100 * duration) + 1))


@pytest.mark.parametrize("phi", [-0.4, 0.9, 1.5])
def test_without_gravity_a_uniform_moment_gives_the_arc_to_second_order(phi):
    arc = np.array([(1 - np.cos(phi)) / phi, np.sin(phi) / phi]) * 0.24
    errors = []
    for n in (8, 16, 32):
        motion = ChainPlant(n, 5e-4, WEIGHTLESS).simulate(constant(KEQ * phi))
        errors.append(np.hypot(motion.x[-1, -1] - arc[0], motion.z[-1, -1] - arc[1]))
    assert errors[2] < 6e-5
    assert np.allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.15)


def test_a_slender_clamped_rod_swings_at_its_first_frequency():
    arm = Arm(diameter=0.004, g=0.0)
    omega = 1.8751041**2 * np.sqrt(KEQ * arm.length / (arm.line_mass * arm.length**4))
    n, step = 24, 1e-4
    engine = Chain(arm, np.full(n, KEQ), np.full(n, C / 50), step)
    engine.data.qpos[:] = 2e-3 * (1 - (np.arange(n) + 0.5) / n) ** 2  # close to the first mode
    x = []
    for _ in range(5000):
        engine.advance(np.zeros(n), None, None, np.zeros(2))
        x.append(engine.nodes().position[0, -1])
    x = np.array(x)
    down = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    crossings = step * (down + x[down] / (x[down] - x[down + 1]))
    assert 2 * np.pi / np.mean(np.diff(crossings)) == pytest.approx(omega, rel=5e-3)


def test_hanging_still_it_balances_moments_about_every_joint():
    tau, n = 0.6, 32
    motion = ChainPlant(n, 5e-4).simulate(constant(tau))
    x, z, angle = motion.x[0], motion.z[0], motion.angle[0]
    h = 0.24 / n
    bend = n * np.diff(angle)
    joint = x[:-1] + h / 2 * np.sin(angle[:-1])
    # Masses of the links between joints, and x of their middles, which are the nodes.
    mass = np.full(n, 0.15 / n)
    mass[-1] /= 2
    middle = x[1:].copy()
    middle[-1] -= h / 4 * np.sin(angle[-1])
    weight = np.array([9.81 * np.sum(mass[i:] * (middle[i:] - joint[i])) for i in range(n)])
    assert np.allclose(KEQ * bend, tau - weight, atol=2e-5)
    assert z[-1] > 0.2


def test_the_energy_loss_of_a_free_arm_equals_the_work_of_its_dampers():
    n, arm, step = 24, WEIGHTLESS, 2e-5
    engine = Chain(arm, np.full(n, KEQ), np.full(n, C / 5), step)
    engine.data.qpos[:] = 0.8 / n
    import mujoco

    engine.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    energy, work = [], [0.0]
    for _ in range(5000):
        rate = engine.read()[1]
        engine.advance(np.zeros(n), None, None, np.zeros(2))
        energy.append(engine.data.energy.sum())
        both = (rate + engine.read()[1]) / 2
        work.append(work[-1] + step * C / 5 * np.mean(both**2))
    lost = energy[0] - np.array(energy)
    assert np.all(np.diff(energy) <= 1e-12)
    assert np.allclose(lost, work[:-1], atol=2e-3 * energy[0])


def test_the_backbone_equals_that_of_the_engine():
    engine = Chain(Arm(), np.full(12, KEQ), np.full(12, C), 5e-4)
    for _ in range(200):
        engine.advance(np.full(12, 0.9), None, None, np.array([0.0, 9.81]))
    import mujoco

    mujoco.mj_kinematics(engine.model, engine.data)
    nodes = engine.nodes()
    joints = nodes.position[:, :-1] + 0.01 * np.stack([np.sin(nodes.angle[:-1]), np.cos(nodes.angle[:-1])])
    assert np.allclose(joints, engine.data.xpos[1:, ::2].T, atol=1e-12)


def test_forces_on_nodes_do_the_work_that_the_joints_see():
    rng = np.random.default_rng(0)
    engine = Chain(Arm(), np.full(6, KEQ), np.full(6, C), 5e-4)
    engine.data.qpos[:] = q = rng.normal(0, 0.2, 6)
    force = rng.normal(size=(2, 7))
    torque, step = engine._torque(force), 1e-6
    for i in range(6):
        ends = []
        for side in (-1, 1):
            engine._nodes = None
            engine.data.qpos[:] = q + side * step * (np.arange(6) == i)
            ends.append(engine.nodes().position)
        assert torque[i] == pytest.approx(np.sum(force * (ends[1] - ends[0])) / (2 * step), abs=1e-8)


@pytest.mark.parametrize("keq", [1.11, 2.33])
def test_the_default_step_is_converged(keq):
    trial = [t for t in program().trials if t.keq == keq][2]
    trial = replace(trial, command=trial.command[25:66], duration=0.4)
    plant = ChainPlant(elements=16)
    assert tip_rms(plant.simulate(trial), replace(plant, step=plant.step / 4).simulate(trial)) < 0.05


@pytest.mark.long
def test_the_default_number_of_elements_is_converged():
    trial = program().trials[2]
    assert tip_rms(ChainPlant().simulate(trial), ChainPlant(elements=64).simulate(trial)) < 0.05


def test_a_plant_that_grows_longer_has_diverged():
    class Stretched(Chain):
        def nodes(self):
            return super().nodes()._replace(position=1.1 * super().nodes().position)

    arm, s = Arm(), (np.arange(6) + 0.5) / 6
    trial = constant(0.0, 0.2)
    engine = Stretched(arm, np.full(6, KEQ), np.full(6, C), 1e-3)
    with pytest.raises(SimulationFailure, match="diverged"):
        Integration(engine, Joints(s, KEQ, np.full(6, KEQ)), arm, trial, (), 1e-3, planar).run(np.linspace(0.0, arm.length, 7))


def test_a_plant_that_curls_through_itself_is_refused_and_one_that_curls_far_is_not():
    plant = ChainPlant(8, 1e-3, WEIGHTLESS)
    assert plant.simulate(constant(1.9 * np.pi * KEQ, 0.1)).angle[-1, -1] == pytest.approx(1.9 * np.pi, abs=0.02)
    with pytest.raises(SimulationFailure, match=r"more than a turn at t = 0\.00 s"):
        plant.simulate(constant(2.1 * np.pi * KEQ, 0.1))
