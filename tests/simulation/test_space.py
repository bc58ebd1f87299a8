"""An arm in space is a chain of spherical joints with springs on their rotation vectors, and in a plane it is today's arm."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hsr_pin.effects import parse_effect
from hsr_pin.errors import InputError, SpecificationError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.load import Load
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.simulation.space import kernel, reference

PLANE = ArmSpecification(links=5, placement="mid", mount="horizontal", tilt=0.3, tip_mass=0.02)
SPACE = replace(PLANE, bending="space", cross_tilt=-0.4)
EFFECTS = ("dry_friction:level=0.05", "stiffening:cubic=0.3", "actuator_lag:time_constant=0.05")


def in_space(scenario, **changes):
    """The same scenario for an arm in space."""
    torque = np.column_stack([scenario.torque, 0 * scenario.torque])
    return replace(scenario, arm=replace(scenario.arm, bending="space"), torque=torque, **changes)


def pushed(arm, samples=51, effects=()):
    """Two components of torque, and two loads, one of which comes and goes."""
    time = np.arange(samples) * 0.01
    torque = np.where(time[:, None] < 0.1, 0.0, [0.6, -0.4])
    force = np.where((time[:, None] > 0.2) & (time[:, None] < 0.4), [0.2, 0.5, -0.3], 0.0)
    loads = (Load(0.8 * arm.length, force, [0.0, 0.05, 0.02]), Load(0.3 * arm.length, [0.2, 0.0, 0.1]))
    return Scenario(arm, time, torque, loads=loads, effects=effects)


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
@pytest.mark.parametrize("effects", [(), EFFECTS], ids=["plain", "effects"])
@pytest.mark.parametrize("placement", ["base", "mid", "shifted"])
def test_in_a_plane_space_is_the_plane(placement, effects, mount):
    arm = replace(PLANE, placement=placement, mount=mount, keq=2.0)
    step = step_scenario(arm, 0.8, duration=0.8, effects=tuple(map(parse_effect, effects)))
    (plane,), (space,) = simulate_batch([step]), simulate_batch([in_space(step)])
    assert np.abs(plane.trajectory.positions - space.trajectory.positions).max() < 1e-9
    assert np.ptp(plane.trajectory.positions) > 0.1


@pytest.mark.parametrize("effects", [(), EFFECTS], ids=["plain", "effects"])
@pytest.mark.parametrize("torsion", [np.inf, 0.8, 0.0])
def test_compiled_is_pinocchio(torsion, effects):
    scenario = pushed(replace(SPACE, torsion=torsion), effects=tuple(map(parse_effect, effects)))
    if torsion == 0:  # a moment along an arm that twists freely has nothing to rest on
        scenario = replace(scenario, loads=tuple(replace(load, moment=np.zeros(3)) for load in scenario.loads))
    compiled, pinocchio = (simulate(scenario, dynamics=way).trajectory for way in ("compiled", "rnea"))
    assert np.abs(compiled.positions - pinocchio.positions).max() < 1e-10
    assert np.ptp(compiled.positions[:, -1], axis=0).min() > 0.01  # it left every plane
    assert np.any(compiled.joint_angles[..., 2]) == (torsion < np.inf)


@pytest.mark.parametrize("torsion", [np.inf, 0.8])
@pytest.mark.parametrize("placement", ["base", "mid", "shifted"])
def test_accelerations_of_the_recursion_are_those_of_the_mass_matrix(placement, torsion):
    arm = replace(SPACE, placement=placement, torsion=torsion)
    loads = (Load(0.1), Load(0.24))
    batch = ArmBatch.of([Scenario(arm, [0, 0.01], np.zeros((2, 2)), loads=loads)] * 4)
    random = np.random.default_rng(3)
    q, v, moment = (random.normal(0, size, (4, 15)) for size in (0.8, 4.0, 0.5))
    moment[:, 2::3] = 0.0
    if torsion == np.inf:
        q[:, 2::3], v[:, 2::3] = 0.0, 0.0
    after = []
    for way, system in ((kernel, batch.arrays), (reference, batch.pinocchio("rnea"))):
        rates = v.copy()
        way.substep(
            system,
            q.copy(),
            rates,
            np.zeros((0, 4, 5), complex),
            moment,
            np.tile(np.linspace(-1, 1, 14), (4, 1)),
            0.01,
            np.zeros((kernel.ROWS, 15)),
        )
        after.append(rates)
    assert np.abs(after[0] - after[1]).max() < 1e-10 * np.abs(after[0] - v).max()


def test_a_whole_run_is_the_exact_motion_of_pinocchios_chain():
    arm = replace(SPACE, links=2, torsion=0.9, damping=0.02)
    start, time = np.array([[0.4, -0.2, 0.1], [0.3, 0.5, -0.2]]), np.arange(31) * 0.01
    scenario = Scenario(arm, time, np.tile([0.3, 0.2], (31, 1)), Pose(start))
    system = ArmBatch.of([scenario]).pinocchio("rnea")

    def slope(_, y):
        return np.append(
            y[6:], reference.acceleration(system, 0, y[:6], y[6:], np.zeros((0, 1, 2)), np.zeros(6), np.array([0.3, 0.2]), 0.0)
        )

    exact = solve_ivp(slope, time[[0, -1]], [*start.ravel(), *np.zeros(6)], "Radau", time, rtol=1e-9, atol=1e-11).y[:6].T
    run = simulate(scenario, tolerance=1e-8)
    np.testing.assert_allclose(run.trajectory.joint_angles.reshape(31, 6), exact, rtol=0, atol=1e-6)


@pytest.mark.parametrize("torsion", [np.inf, 0.8])
def test_the_account_of_energy_never_rises(torsion):
    for scenario in (pushed(replace(SPACE, torsion=torsion)), step_scenario_in_space(torsion)):
        loads = tuple(replace(load, moment=np.zeros(3)) for load in scenario.loads)
        result = simulate(replace(scenario, loads=loads), tolerance=1e-6)
        assert result.energy().rise < 1e-4
        assert result.warning == ""


def step_scenario_in_space(torsion):
    return in_space(step_scenario(replace(PLANE, damping=0.01, placement="base"), 0.5, duration=0.6))


def test_an_arm_without_damping_keeps_its_energy():
    arm = replace(SPACE, damping=0.0, torsion=0.5)
    start = np.random.default_rng(0).normal(0, 0.2, (arm.links, 3))
    scenario = Scenario(arm, np.arange(41) * 0.005, np.zeros((41, 2)), Pose(start))
    account = simulate(scenario, dynamics="compiled", integrator="extrapolated5", tolerance=1e-8).energy().account
    assert np.ptp(account) < 1e-5 * np.ptp(simulate(scenario, dynamics="compiled").energy().kinetic)


@pytest.mark.parametrize("way", ["compiled", "rnea"])
def test_a_rest_stays_where_it_is(way):
    scenario = pushed(replace(SPACE, torsion=0.7), samples=31)
    held = tuple(Load(load.arc_length, np.asarray(load.force).reshape(-1, 3)[-1] + 0.3, load.moment) for load in scenario.loads)
    still = replace(scenario, torque=np.full((31, 2), 0.3), loads=held, start=Settled(0.3 + 0.3j))
    positions = simulate(still, dynamics=way).trajectory.positions
    assert np.abs(positions - positions[0]).max() < 1e-9
    assert abs(positions[0, -1, 1]) > 0.02


def test_a_force_at_the_tip_bends_a_stiff_arm_as_a_beam():
    """F L^3 / (3 EI), with EI = Keq L; in any direction across."""
    arm = ArmSpecification(30, keq=100.0, placement="shifted", mass=1e-3, bending="space", torsion=100.0)
    for force in ([0.3, 0.0, 0.0], [0.0, -0.2, 0.0], [0.1, 0.2, 0.0]):
        scenario = Scenario(arm, [0, 0.01], np.zeros((2, 2)), loads=(Load(arm.length, force),))
        tip = simulate(scenario).trajectory.positions[0, -1]
        np.testing.assert_allclose(tip[:2], np.array(force[:2]) * arm.length**2 / (3 * arm.keq), rtol=1e-3)


def test_a_moment_along_the_arm_twists_it_by_its_torsion():
    arm = ArmSpecification(8, mount="upright", mass=1e-9, bending="space", torsion=0.5, placement="mid")
    scenario = Scenario(arm, [0, 0.01], np.zeros((2, 2)), loads=(Load(arm.length, moment=[0.0, 0.0, 0.2]),))
    twist = simulate(scenario).trajectory.joint_angles[0, :, 2]
    np.testing.assert_allclose(twist, 0.2 / 0.5 / 8, rtol=1e-6)


def test_turning_torque_and_tilt_about_the_arm_turns_the_motion():
    """Nothing but their direction tells x from y."""
    arm = replace(SPACE, mount="hanging", tilt=0.3, cross_tilt=0.0)
    turned = replace(arm, tilt=0.3 * np.cos(0.7), cross_tilt=0.3 * np.sin(0.7))
    effects = tuple(map(parse_effect, EFFECTS))
    time, command = np.arange(41) * 0.01, np.tile([0.5, 0.2], (41, 1))
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    one = simulate(Scenario(arm, time, command, effects=effects), dynamics="compiled").trajectory.joint_angles
    other = simulate(Scenario(turned, time, command @ turn.T, effects=effects), dynamics="compiled").trajectory.joint_angles
    np.testing.assert_allclose(other[..., :2], one[..., :2] @ turn.T, atol=2e-5)  # steps are judged by components


def test_many_arms_keep_to_their_columns():
    arms = [replace(SPACE, keq=keq, torsion=torsion) for keq, torsion in ((1.0, 0.5), (2.0, np.inf), (1.5, 1.0))]
    together = simulate_batch([pushed(arm) for arm in arms], threads=2)
    for arm, result in zip(arms, together, strict=True):
        alone = simulate(pushed(arm), dynamics="compiled")
        np.testing.assert_array_equal(alone.trajectory.positions, result.trajectory.positions)


def test_what_only_space_has_is_refused_in_the_plane():
    step = step_scenario(PLANE, 0.5, duration=0.1)
    for refused in (lambda: replace(step, loads=(Load(0.1),)), lambda: replace(step, start=Settled(0.1 + 0.1j))):
        with pytest.raises(InputError, match="space"):
            refused()
    with pytest.raises(SpecificationError, match="torsion"):
        replace(PLANE, torsion=1.0)
    with pytest.raises(SpecificationError, match="cross_tilt"):
        replace(PLANE, cross_tilt=0.1)


def test_what_space_does_not_have_is_refused_there():
    with pytest.raises(InputError, match="compiled or rnea"):
        simulate(in_space(step_scenario(PLANE, 0.5, duration=0.1)), dynamics="aba")
    with pytest.raises(InputError, match="defined for arms in space"):
        in_space(step_scenario(PLANE, 0.5, duration=0.1, effects=(parse_effect("torque_map:quadratic=0.1,parity=even"),)))
    with pytest.raises(InputError, match="towards x and towards y"):
        Scenario(SPACE, [0, 0.1], [0.0, 0.0])
    with pytest.raises(InputError, match="samples"):
        Scenario(SPACE, [0, 0.1], np.zeros((2, 2)), loads=(Load(0.1, np.zeros((5, 3))),))


def test_an_arm_that_is_bent_at_rest_rests_bent():
    bend = parse_effect("bend_at_rest:towards_x=0.3,towards_y=-0.2")
    arm = replace(SPACE, mass=1e-6, tip_mass=0.0)
    for way in ("compiled", "rnea"):
        rest = simulate(Scenario(arm, [0, 0.01], np.zeros((2, 2)), effects=(bend,)), dynamics=way).trajectory.joint_angles[0]
        np.testing.assert_allclose(rest.sum(axis=0), [0.3, -0.2, 0.0], atol=1e-4)
    with pytest.raises(InputError, match="expected laws that are defined for planar arms, got bend_at_rest"):
        step_scenario(PLANE, 0.1, effects=(bend,))


def test_a_load_beyond_the_arm_is_refused():
    with pytest.raises(InputError, match=r"arc length of a load: expected from 0 to .* 0\.24 m, got 0\.3"):
        Scenario(SPACE, [0, 0.1], np.zeros((2, 2)), loads=(Load(0.3),))
