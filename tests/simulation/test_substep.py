"""The accelerations are right: by the compiled recursion, ABA, RNEA, Euler and Lagrange, and on a robot that we did not write."""

from functools import cache
from importlib.metadata import files
from math import cos, sin
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from hsr_pin.errors import InputError
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation import integrate, kernel, reference
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.integrator import ORDERS, Integrator
from hsr_pin.simulation.reference import PinocchioSystem
from hsr_pin.simulation.scenario import Pose, Scenario, step_scenario
from hsr_pin.simulation.simulate import simulate

PLACEMENTS, MOUNTS = ("base", "mid"), ("hanging", "upright", "horizontal")


WAYS = ("compiled", "aba", "rnea")


def motion(links, count=10):
    """Random angles [rad], rates [rad/s], (B, N)."""
    random = np.random.default_rng(links)
    return tuple(random.normal(0, size, (count, links)) for size in (0.8, 5.0))


def accelerations(arms, q, v, torque, dynamics="aba", armature=0.0):
    """(B, N) [rad/s^2] with springs, dampers and the muscles' torque, through the parts that the simulation is made of.

    A substep of length 1 whose implicit part is the armature alone gives them as the change of the rates.
    """
    batch = ArmBatch.of([Scenario(arm, [0.0, 0.01], [torque, torque]) for arm in arms])
    nothing, same = np.zeros_like(q), np.full_like(q, armature)
    batch.__dict__["arrays"] = batch.arrays._replace(stiff=nothing, drag=same)
    way, system = (kernel, batch.system) if dynamics == "compiled" else (reference, batch.pinocchio(dynamics))
    after = v.copy()
    way.substep(
        system, q.copy(), after, nothing[None][:0], nothing, np.full(len(q), torque), 1.0, np.zeros((kernel.SCRATCH, q.shape[1]))
    )
    return after - v


@cache
def lagrange(bodies):
    """f(q, v, numbers) -> mass matrix and right-hand side, derived with SymPy for a planar chain in its own coordinates.

    The numbers: per body its length, distance to its centre, mass, inertia; then where the first joint is along the fixed base,
    tip mass, stiffness, damping, torque, gravity, and the upward components of the straight arm and of its bending side.
    """
    q, v = (sp.Matrix(sp.symbols(f"{name}:{bodies}")) for name in "qv")
    length, centre, mass, inertia = (sp.symbols(f"{name}:{bodies}") for name in ("l", "d", "m", "J"))
    first, tip, k, c, tau, g, along_up, side_up = rest = sp.symbols("first tip k c tau g along_up side_up")
    joint, turn, kinetic, potential = sp.Matrix([first, 0]), 0, 0, 0
    for i in range(bodies):
        turn += q[i]
        way = sp.Matrix([sp.cos(turn), sp.sin(turn)])
        for point, weight in ((joint + centre[i] * way, mass[i]), (joint + length[i] * way, tip if i == bodies - 1 else 0)):
            speed = point.jacobian(q) * v
            kinetic += weight * speed.dot(speed) / 2
            potential += weight * g * (along_up * point[0] + side_up * point[1])
        kinetic += inertia[i] * sum(v[: i + 1]) ** 2 / 2
        potential += k * q[i] ** 2 / 2
        joint += length[i] * way
    momentum, force = (sp.Matrix([expression]).jacobian(x).T for expression, x in ((kinetic, v), (kinetic - potential, q)))
    right = force - c * v + tau * sp.ones(bodies, 1) - momentum.jacobian(q) * v
    return sp.lambdify([list(q), list(v), [*length, *centre, *mass, *inertia, *rest]], (momentum.jacobian(v), right), cse=True)


def numbers_of(arm, torque):
    """What :func:`lagrange` needs, from Table I and geometry alone."""
    share = np.ones(arm.links)
    if arm.placement == "mid":
        share[-1] = 0.5
    length, mass = share * arm.length / arm.links, share * arm.mass / arm.links
    inertia = mass * (3 * (arm.diameter / 2) ** 2 + length**2) / 12
    along, side = {"hanging": ((0, -1), (1, 0)), "upright": ((0, 1), (1, 0)), "horizontal": ((1, 0), (0, -1))}[arm.mount]
    along_up = cos(arm.tilt) * along[1] + sin(arm.tilt) * side[1]
    side_up = cos(arm.tilt) * side[1] - sin(arm.tilt) * along[1]
    first = arm.length / arm.links / 2 if arm.placement == "mid" else 0.0
    k, c = arm.links * arm.keq, arm.links * arm.damping
    return [*length, *(length / 2), *mass, *inertia, first, arm.tip_mass, k, c, torque, 9.81, along_up, side_up]


@pytest.mark.parametrize("dynamics", WAYS)
@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("links", [2, 3])
def test_accelerations_are_those_of_euler_and_lagrange(links, placement, mount, dynamics):
    arm = ArmSpecification(links=links, placement=placement, mount=mount, tip_mass=0.05, tilt=0.3)
    q, v = motion(links)
    equations, numbers = lagrange(links), numbers_of(arm, 0.7)
    expected = np.array([np.linalg.solve(*equations(x, y, numbers)).ravel() for x, y in zip(q, v, strict=True)])
    got = accelerations([arm] * len(q), q, v, 0.7, dynamics)
    assert np.abs(got - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("armature", [0.0, 0.02])
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("links", [1, 4, 20])
def test_accelerations_are_equal_on_all_three_ways(links, placement, armature):
    arm = ArmSpecification(links=links, placement=placement, mount="horizontal", tip_mass=0.02)
    q, v = motion(links)
    compiled, aba, rnea = (accelerations([arm] * len(q), q, v, 0.7, way, armature) for way in WAYS)
    assert np.abs(aba - rnea).max() <= 1e-9 * np.abs(rnea).max()
    assert np.abs(aba - compiled).max() <= 1e-9 * np.abs(aba).max()


def test_a_whole_run_is_that_of_euler_and_lagrange():
    arm = ArmSpecification(links=2, placement="mid", mount="horizontal", tip_mass=0.05, tilt=0.3)
    start, time = np.array([0.4, -0.1]), np.arange(31) * 0.01
    equations, numbers = lagrange(2), numbers_of(arm, 0.5)

    def slope(_, y):
        return np.concatenate([y[2:], np.linalg.solve(*equations(y[:2], y[2:], numbers)).ravel()])

    exact = solve_ivp(slope, time[[0, -1]], [*start, 0, 0], "Radau", time, rtol=1e-9, atol=1e-11).y[:2].T
    run = simulate(Scenario(arm, time, np.full(31, 0.5), Pose(start)), step=5e-4)
    np.testing.assert_allclose(run.trajectory.joint_angles, exact, rtol=0, atol=2e-8)


@pytest.mark.parametrize("dynamics", WAYS)
def test_different_arms_side_by_side_keep_to_their_columns(dynamics):
    arms = [ArmSpecification(links=3, tip_mass=mass) for mass in (0.0, 0.0, 0.1, 0.05, 0.05)]
    q, v = motion(3, len(arms))
    together = accelerations(arms, q, v, 0.2, dynamics, armature=0.01)
    for b, arm in enumerate(arms):
        alone = accelerations([arm], q[b : b + 1], v[b : b + 1], 0.2, dynamics, armature=0.01)
        np.testing.assert_array_equal(alone[0], together[b])


def test_the_shared_model_keeps_no_armature():
    arm = ArmSpecification(links=3)
    simulate(step_scenario(arm, 0.5, duration=0.05))
    assert np.all(build_model(arm).model.armature == 0)


def test_an_unknown_dynamics_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="expected compiled or aba or rnea, got 'lagrange'"):
        simulate(step_scenario(ArmSpecification(), 0.5, duration=0.05), dynamics="lagrange")


class DoublePendulum:
    """example-robot-data's double pendulum with a spring and a damper at each joint, for the loop over Pinocchio."""

    k, c = 2.0, 0.05

    def __init__(self, dynamics):
        path = next(f for f in files("example-robot-data") if f.name == "double_pendulum.urdf")
        self.model = pin.buildModelFromUrdf(str(path.locate()))
        spring, damper = np.full((1, 2), self.k), np.full((1, 2), self.c)
        joints = {"share": np.zeros((1, 2)), "spring": spring, "stiff": spring, "damper": damper, "drag": damper}
        arrays = SimpleNamespace(**joints, world=np.zeros((1, 0, 1)))
        self.system = PinocchioSystem(arrays, (self.model,), (self.model.createData(),), (), dynamics)


def pendulum_run(name, dynamics, steps, duration=0.5):
    q, v, z = np.array([[1.0, -0.5]]), np.zeros((1, 2)), np.zeros((0, 1, 2))
    angles, rates = np.zeros((2, steps + 1, 1, 2))
    integrate.integrate(
        DoublePendulum(dynamics).system, q, v, z, np.zeros((1, steps + 1)), duration / steps, 1, np.arange(1.0, steps + 2),
        Integrator(name, step=duration / steps).weights, np.inf, 1.0, 1.0, np.full(1, np.inf), angles, rates,
        np.full(1, np.inf), np.zeros(steps), np.zeros((1, 2)),
    )  # fmt: skip
    return np.concatenate([angles[-1, 0], rates[-1, 0]])


@pytest.fixture(scope="module")
def pendulum_exact():
    chain = DoublePendulum("aba")
    data = chain.model.createData()

    def slope(_, y):
        return np.concatenate([y[2:], pin.aba(chain.model, data, y[:2], y[2:], -chain.k * y[:2] - chain.c * y[2:])])

    return solve_ivp(slope, [0, 0.5], [1.0, -0.5, 0, 0], "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def test_the_foreign_pendulum_moves_the_same_by_aba_and_rnea():
    aba, rnea = (pendulum_run("extrapolated4", dynamics, 50) for dynamics in ("aba", "rnea"))
    np.testing.assert_allclose(aba, rnea, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ORDERS)
def test_the_foreign_pendulum_converges_to_scipys_motion(name, pendulum_exact):
    order = ORDERS[name]
    steps, slack = {5: ((160, 320), 0.3), 6: ((120, 240), 0.3)}.get(order, ((320, 640), 0.15))  # more, and rounding would rule
    coarse, fine = (np.abs(pendulum_run(name, "aba", n) - pendulum_exact).max() for n in steps)
    assert np.log2(coarse / fine) >= order - slack
