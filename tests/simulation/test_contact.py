"""Contact with obstacles keeps the closed forms of mechanics, in a plane and in space, compiled and with Pinocchio."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.obstacles import Box, Cylinder, HalfSpace, Sphere, Surface
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.load import Load
from hsr_pin.simulation.motion import Engine
from hsr_pin.simulation.scenario import Pose, Scenario, step_scenario
from hsr_pin.simulation.simulate import simulate

GROUND = HalfSpace(point=(0.0, 0.0, -0.05))
POST = Cylinder(centre=(0.06, 0.0, -0.14), radius=0.01)
WALL = HalfSpace(point=(0.1, 0.0, 0.0), normal=(-1.0, 0.0, 0.3))
SLOPE = Box(centre=(0.12, 0.0, -0.2), size=(0.06, 0.2, 0.06), rotation=(0.0, 0.4, 0.0))
#: Largest stiffness of gravity relative to that of the arm, which a step does not know.
GRAVITY_SHARE = 0.3
BALL = Sphere(centre=(0.09, 0.01, -0.15), radius=0.02)


def swing(*obstacles, torque=1.5, links=8, **more):
    arm = ArmSpecification(links=links, placement="shifted", obstacles=obstacles, **more)
    return step_scenario(arm, torque, duration=1.0)


def drop(obstacle, links=16, **more):
    arm = ArmSpecification(
        links=links, placement="shifted", mount="horizontal", keq=0.2, damping=0.005, obstacles=(obstacle,), **more
    )
    parts = (links, 3) if arm.bending == "space" else (links,)
    return Scenario(arm, np.arange(151) * 0.01, np.zeros((151, 2) if arm.bending == "space" else 151), Pose(np.zeros(parts)))


@pytest.mark.parametrize("obstacle", [POST, WALL, SLOPE, BALL], ids=lambda o: o.shape)
def test_every_way_to_simulate_gives_the_same_motion(obstacle):
    plane = swing(obstacle, links=5)
    space = swing(obstacle, links=5, bending="space")
    runs = [simulate(plane, dynamics=way) for way in ("compiled", "rnea")]
    if obstacle is not BALL:  # it is beside the plane and pushes an arm in space out of it
        runs.append(simulate(space, dynamics="compiled"))
    free = simulate(swing(links=5))
    assert np.abs(runs[0].trajectory.positions - free.trajectory.positions).max() > 5e-3
    for other in runs[1:]:
        np.testing.assert_allclose(other.trajectory.positions, runs[0].trajectory.positions, atol=1e-7)
    apart = [
        simulate(replace(space, time=space.time[:40], torque=space.torque[:40]), dynamics=way) for way in ("compiled", "rnea")
    ]
    np.testing.assert_allclose(apart[0].trajectory.positions, apart[1].trajectory.positions, atol=1e-7)


@pytest.mark.parametrize(
    "scenario", [drop(GROUND), swing(POST, links=16), swing(WALL, links=16, torque=1.8)], ids=["drop", "post", "wall"]
)
def test_a_motion_is_within_a_tenth_of_a_millimetre_of_steps_of_a_hundredth(scenario):
    usual, fine = (
        simulate(scenario, dynamics="compiled"),
        simulate(scenario, dynamics="compiled", integrator="extrapolated2", step=2e-5),
    )
    assert np.abs(fine.contact_forces().force).max() > 0.1  # it touches
    assert np.abs(usual.trajectory.positions - fine.trajectory.positions).max() < 1e-4
    close = simulate(scenario, dynamics="compiled", tolerance=1e-6)
    last, exact = close.contact_forces().force[-1], fine.contact_forces().force[-1]
    assert np.linalg.norm(last - exact) < 0.01 * np.linalg.norm(exact)


@pytest.mark.parametrize("dissipation", [0.0, 2.0])
@pytest.mark.parametrize("space", [False, True])
def test_energy_never_grows_and_stays_without_losses(dissipation, space):
    bending = {"bending": "space"} if space else {}
    ground = replace(GROUND, stiffness=1e5, dissipation=dissipation, friction=0.0)
    scenario = drop(ground, links=8, **bending)
    scenario = replace(scenario, arm=replace(scenario.arm, damping=0.0))
    run = simulate(scenario, dynamics="compiled", integrator="extrapolated2", tolerance=1e-7)
    energy = run.energy()
    pressed = np.linalg.norm(run.contact_forces().force, axis=2).max(axis=1) > 0
    assert pressed.any() and not pressed.all()  # it bounces
    scale = energy.kinetic.max()
    assert energy.rise < 1e-3
    lost = (energy.account[0] - energy.account[-1]) / scale
    assert lost < 1e-2 if dissipation == 0 else lost > 0.02


@pytest.mark.parametrize(("mount", "bending"), [("horizontal", "plane"), ("horizontal", "space")])
def test_a_cantilever_on_a_stop_presses_as_signorini_says(mount, bending):
    length, mass, keq = 0.24, 0.15, 50.0
    stiffness, line_load = keq * length, mass * 9.81 / length
    free = line_load * length**4 / (8 * stiffness)
    gap, radius = free / 2, 0.002
    stop = HalfSpace(point=(0.0, 0.0, -gap - radius), stiffness=1e9, friction=0.0)
    arm = ArmSpecification(
        links=32, placement="shifted", mount=mount, bending=bending, keq=keq, damping=5.0, diameter=2 * radius, obstacles=(stop,)
    )
    torque = np.zeros((3, 2)) if bending == "space" else np.zeros(3)
    run = simulate(Scenario(arm, np.arange(3) * 0.01, torque), dynamics="compiled")
    force = run.contact_forces()
    expected = 3 * stiffness / length**3 * (free - gap)
    assert force.force[0, 0, 2] == pytest.approx(expected, rel=5e-3)
    assert force.point[0, 0, 0] == pytest.approx(length, abs=1e-3)
    assert np.abs(run.trajectory.positions[-1] - run.trajectory.positions[0]).max() < 1e-8  # it is at rest


def test_friction_holds_an_arm_round_a_post_up_to_the_exponential_of_the_angle():
    """L. Euler and J. A. Eytelwein: a belt round a post slides if the ratio of its tensions exceeds exp(mu theta)."""
    friction, radius, thin = 0.3, 0.03, 0.004
    post = Cylinder(centre=(0.15, 0.0, -radius - thin / 2), radius=radius, friction=friction, stiffness=1e7)
    arm = ArmSpecification(
        links=80, placement="shifted", mount="horizontal", bending="space", length=0.4, mass=1e-3, diameter=thin, keq=2e-4,
        damping=2e-4, bending_limit=20.0, obstacles=(post,),
    )  # fmt: skip
    time = np.arange(301) * 0.005
    bent = np.zeros((80, 3))
    bent[30:49, 0] = np.pi / 2 / 19  # it hangs over the post
    limit = np.exp(friction * np.pi / 2)
    for pull, slides in ((0.8 * limit, False), (1.15 * limit, True)):
        loads = (Load(0.14, force=(-pull, 0.0, 0.0)), Load(0.4, force=(0.0, 0.0, -1.0)))
        run = simulate(Scenario(arm, time, np.zeros((301, 2)), Pose(bent), loads=loads), dynamics="compiled")
        horizontal, _, vertical = run.contact_forces().force[-1, 0]
        way = run.trajectory.positions[-1, -1, 2] - run.trajectory.positions[-101, -1, 2]
        if slides:
            assert horizontal / vertical == pytest.approx(limit, rel=0.02)
            assert way > 5e-4
        else:
            assert horizontal / vertical < 0.98 * limit
            assert abs(way) < 2e-5


@pytest.mark.parametrize("space", [False, True])
def test_a_long_step_is_one_of_newtons_and_returns_to_rest(space):
    """The implicit part of a contact is its exact stiffness: the error after a step is of second order."""
    ground = replace(GROUND, friction=0.0)
    bending = "space" if space else "plane"
    arm = ArmSpecification(
        links=6, placement="shifted", mount="horizontal", keq=1.0, tip_mass=0.3, bending=bending, obstacles=(ground,)
    )
    torque = np.zeros((2, 2)) if space else np.zeros(2)
    scenario = Scenario(arm, np.array([0.0, 0.01]), torque)
    rest = simulate(scenario, dynamics="compiled").trajectory.joint_angles[0].reshape(1, -1)
    engine = Engine(ArmBatch.of([scenario]), "compiled")
    shift = np.random.default_rng(1).normal(size=rest.shape) * (np.arange(rest.size) % 3 < 2 if space else 1.0)
    errors = []
    for size in (1e-4, 1e-5):
        state = np.concatenate([rest + size * shift, np.zeros_like(rest)])[:, None]
        load = np.zeros((1, 2), dtype=complex if space else float)
        engine.advance(state, load, 1e3, np.array([[1.0], [0.0]]))
        errors.append(np.abs(state[0, 0] - rest).max() / size)
    assert max(errors) < GRAVITY_SHARE


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: HalfSpace(normal=(0, 0, 0)), "normal"),
        (lambda: Cylinder(radius=0.0), "radius"),
        (lambda: Sphere(centre=(0, inf, 0)), "centre"),
        (lambda: Box(size=(1, 0, 1)), "size"),
        (lambda: HalfSpace(stiffness=0.0), "stiffness"),
        (lambda: HalfSpace(friction=-0.1), "friction"),
        (lambda: Surface.of("wool"), "material"),
    ],
)
def test_a_wrong_obstacle_is_refused_by_name(make, word):
    with pytest.raises(InputError, match=word):
        make()


def test_arms_of_several_lengths_in_one_batch_move_as_alone():
    scenarios = [swing(POST, length=length, links=6) for length in (0.2, 0.24, 0.3)]
    for together, scenario in zip(simulate_batch(scenarios), scenarios, strict=True):
        (alone,) = simulate_batch([scenario])
        np.testing.assert_allclose(together.trajectory.positions, alone.trajectory.positions, rtol=0, atol=1e-9)
