"""A run is the exact motion to a twentieth of a millimetre, and keeps its energy account."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import simpson

from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_together
from hsr_pin.simulation.compiled import loops
from hsr_pin.simulation.integrator import LONGEST, ORDERS, TOLERANCE, Integrator
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate


def tip_error(scenario, exact_motion):
    """[m] largest distance from the exact motion."""
    links = scenario.arm.links
    tip = marker_map(scenario.arm, [scenario.arm.length])
    exact = tip.positions(exact_motion(scenario, np.zeros(links), tolerance=1e-10)[:, :links])
    return np.linalg.norm(simulate(scenario).trajectory.positions[:, -1] - exact[:, 0], axis=-1).max()


long = pytest.mark.long


@pytest.mark.parametrize("placement", ["base", "mid"])
@pytest.mark.parametrize(
    "links", [1, 2, 4, pytest.param(8, marks=long), pytest.param(16, marks=long), pytest.param(32, marks=long)]
)
def test_the_default_tolerance_keeps_the_tip_within_a_twentieth_of_a_millimetre(placement, links, exact_motion):
    arm = ArmSpecification(links=links, placement=placement)
    assert tip_error(step_scenario(arm, 1.0, duration=0.6), exact_motion) < 2.5e-5
    assert tip_error(step_scenario(arm, 1.0, duration=0.6, step=0.002), exact_motion) < 5e-5


@pytest.mark.parametrize("placement", ["base", "mid"])
@pytest.mark.parametrize("links", [1, 4, 32])
def test_the_error_stays_below_the_tolerance_asked_for(placement, links):
    scenario = step_scenario(ArmSpecification(links=links, placement=placement), 1.0, duration=0.6, step=0.004)
    exact = simulate(scenario, dynamics="compiled", tolerance=1e-9).trajectory.positions
    errors = [
        np.abs(simulate(scenario, dynamics="compiled", tolerance=tolerance).trajectory.positions - exact).max() / tolerance
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    ]
    assert max(errors) < 1.0
    assert min(errors) > 0.02  # and no steps are wasted


@pytest.mark.parametrize("placement", ["base", "mid"])
@pytest.mark.parametrize("links", [1, 2, 4, 32])
@pytest.mark.parametrize("sample", [0.001, 0.002, 0.005, 0.02, 0.1])
@pytest.mark.parametrize("drive", ["step", "wave", "slow"])
def test_samples_within_steps_are_as_good(drive, sample, links, placement):
    """A step and a slow wave (steps of many samples), and a fast one; a held command and its staircase included."""
    arm, time = ArmSpecification(links=links, placement=placement), np.arange(round(1.0 / sample) + 1) * sample
    torque = {"step": np.where(time < 0.2, 0.0, 0.8), "wave": 0.6 * np.sin(9 * time), "slow": 0.6 * np.sin(2 * time)}[drive]
    scenario = Scenario(arm, time, torque, interpolated=drive == "wave")
    seen, exact = (simulate(scenario, dynamics="compiled", tolerance=t).trajectory.positions for t in (TOLERANCE, 1e-8))
    bound = 1e-4 if links < 4 else 5e-5 if drive == "step" else 6e-5
    assert np.linalg.norm(seen - exact, axis=-1).max() < bound


@pytest.mark.parametrize("links", [1, 4, 32])
def test_an_arm_at_rest_takes_the_longest_steps(links):
    arm = ArmSpecification(links=links, mount="horizontal", tip_mass=0.05)
    time = np.arange(4001) * 0.01
    for torque in (np.full(4001, 0.5), np.where((time > 5) & (time < 8), 0.6, 0.5)):
        scenario = Scenario(arm, time, torque, Settled(0.5))
        steps = simulate_together([scenario], ArmBatch.of([scenario]), Integrator(), "compiled").steps
        assert steps.sum() == pytest.approx(40)
        assert len(steps) < 40 / LONGEST + 12 + 35 * np.count_nonzero(np.diff(torque))


def test_memory_grows_with_the_number_of_links_and_no_faster():
    code = (
        "import resource\n"
        "from hsr_pin.robot.specification import ArmSpecification\n"
        "from hsr_pin.simulation.batch import simulate_batch\n"
        "from hsr_pin.simulation.scenario import step_scenario\n"
        "for links in (2, 250, 1000):\n"
        "    (run,) = simulate_batch([step_scenario(ArmSpecification(links=links), 0.8)])\n"
        "    assert run.completed\n"
        "    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )
    loops()  # else the compiler's own memory, in the process that is measured, would hide the arms'
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    start, some, many = map(int, told.split())
    assert many - start < 6 * max(some - start, 2000)  # [kB]


def test_a_step_of_the_input_falls_on_a_step_boundary(exact_motion):
    """A step at 0.13 s, when samples come every 65 ms, costs no accuracy."""
    scenario = step_scenario(ArmSpecification(), 1.0, rest=0.13, duration=0.52, step=0.065)
    assert tip_error(scenario, exact_motion) < 2e-5


@pytest.mark.parametrize("step", [0.003, 0.007, 0.01, 0.025])
def test_samples_do_not_depend_on_how_often_they_are_taken(step):
    coarse = step_scenario(ArmSpecification(), 0.8, rest=0.0, duration=20 * step, step=step)
    fine = step_scenario(ArmSpecification(), 0.8, rest=0.0, duration=20 * step, step=step / 5)
    seen, exact = (simulate(scenario).trajectory.positions for scenario in (coarse, fine))
    np.testing.assert_allclose(seen, exact[::5], rtol=0, atol=2e-5)


def test_the_time_of_the_first_sample_does_not_matter():
    scenario = step_scenario(ArmSpecification(), 0.8, duration=0.2)
    later = replace(scenario, time=scenario.time + 100.0)
    np.testing.assert_allclose(simulate(later).trajectory.positions, simulate(scenario).trajectory.positions, rtol=0, atol=1e-10)


def energy(arm, motion):
    """(T,) [J] kinetic, of gravity and of the springs."""
    model = build_model(arm).model
    data = model.createData()
    rigid = [
        pin.computeKineticEnergy(model, data, q, v) + pin.computePotentialEnergy(model, data, q)
        for q, v in zip(motion.joint_angles, motion.joint_rates, strict=True)
    ]
    return np.array(rigid) + arm.joint_stiffness * (motion.joint_angles**2).sum(axis=1) / 2


def released(arm, sample=1e-3, **options):
    time = np.arange(401) * sample
    return simulate(Scenario(arm, time, np.zeros(401), Pose(np.full(arm.links, 0.6 / arm.links))), **options).trajectory


@pytest.mark.parametrize("name", ORDERS)
@pytest.mark.parametrize("placement", ["base", "mid"])
def test_without_damping_energy_is_kept_to_the_methods_order(name, placement):
    arm, order = ArmSpecification(links=1, damping=0.0, mount="horizontal", placement=placement), ORDERS[name]
    changes = []
    first = {1: 1e-4, 5: 2e-3, 6: 1e-2}.get(order, 1e-3)
    for step in (first, first / 2):
        account = energy(arm, released(arm, sample=max(first, 1e-3), integrator=name, step=step))
        changes.append(np.abs(account - account[0]).max())
    assert np.log2(changes[0] / changes[1]) >= order - (0.15 if order < 6 else 0.5)


@pytest.mark.parametrize("links", [2, 4])
def test_without_damping_a_fine_step_keeps_the_energy_of_a_chain(links):
    arm = ArmSpecification(links=links, damping=0.0)
    account = energy(arm, released(arm, integrator="extrapolated4", step=1e-4))
    stored = arm.keq * 0.6**2 / 2  # in the springs at the start
    assert np.abs(account - account[0]).max() < 1e-5 * stored


@pytest.mark.parametrize("placement", ["base", "mid"])
def test_with_damping_the_loss_of_energy_is_the_dampers_work(placement):
    arm = ArmSpecification(links=3, mount="horizontal", tip_mass=0.05, placement=placement)
    motion = released(arm, step=2.5e-4)
    power = arm.joint_damping * (motion.joint_rates**2).sum(axis=1)
    late = 40  # after the boundary layer of the release, which samples every millisecond do not resolve
    account = energy(arm, motion)[late:]
    work = simpson(power[late:], x=motion.time[late:])
    assert account[0] - account[-1] == pytest.approx(work, rel=1e-6)


def test_the_muscles_bring_in_their_torque_times_the_bending():
    arm = ArmSpecification(links=3, placement="mid")
    time = np.arange(301) * 1e-3
    motion = simulate(Scenario(arm, time, np.full(301, 0.7)), step=2.5e-4).trajectory
    late = 40
    power = arm.joint_damping * (motion.joint_rates[late:] ** 2).sum(axis=1)
    account, bending = energy(arm, motion)[late:], motion.joint_angles[late:].sum(axis=1)
    brought = 0.7 * (bending[-1] - bending[0])
    assert account[-1] - account[0] == pytest.approx(brought - simpson(power, x=time[late:]), rel=1e-6)
