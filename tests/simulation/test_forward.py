"""The accelerations are right: by ABA, by RNEA, by Euler and Lagrange, and on a robot that we did not write."""

from functools import cache
from importlib.metadata import files
from math import cos, sin

import numpy as np
import pinocchio as pin
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.columns import Columns, shape_of
from hsr_pin.simulation.forward import forward_dynamics
from hsr_pin.simulation.integrators import INTEGRATORS
from hsr_pin.simulation.integrators.integrator import workspace
from hsr_pin.simulation.scenario import Pose, Scenario, step_scenario
from hsr_pin.simulation.simulate import simulate

PLACEMENTS, MOUNTS = ("base", "mid"), ("hanging", "upright", "horizontal")


def motion(links, count=10):
    """Random angles [rad], rates [rad/s], (N, B)."""
    random = np.random.default_rng(links)
    return tuple(np.asfortranarray(random.normal(0, size, (links, count))) for size in (0.8, 5.0))


def accelerations(arm, q, v, torque, dynamics="aba", armature=0.0):
    """(N, B) [rad/s^2] with springs, dampers and the muscles' torque, through the parts that the simulation is made of."""
    scenarios = [Scenario(arm, [0.0, 0.01], [torque, torque])] * q.shape[1]
    columns = Columns(scenarios, shape_of(scenarios[0], 0.01))
    models = [arm.model for arm in columns.arm_models]
    forward = forward_dynamics(dynamics, models, [np.full(arm.links, armature)])
    return forward.solve(0, q, v, columns.torque(q, v, ()) + columns.drive * torque)


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


@pytest.mark.parametrize("dynamics", ["aba", "rnea"])
@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("links", [2, 3])
def test_accelerations_are_those_of_euler_and_lagrange(links, placement, mount, dynamics):
    arm = ArmSpecification(links=links, placement=placement, mount=mount, tip_mass=0.05, tilt=0.3)
    q, v = motion(links)
    equations, numbers = lagrange(links), numbers_of(arm, 0.7)
    expected = np.column_stack([np.linalg.solve(*equations(x, y, numbers)).ravel() for x, y in zip(q.T, v.T, strict=True)])
    got = accelerations(arm, q, v, 0.7, dynamics)
    assert np.abs(got - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("armature", [0.0, 0.02])
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("links", [1, 4, 20])
def test_accelerations_of_aba_and_rnea_are_equal(links, placement, armature):
    arm = ArmSpecification(links=links, placement=placement, mount="horizontal", tip_mass=0.02)
    q, v = motion(links)
    aba, rnea = (accelerations(arm, q, v, 0.7, dynamics, armature) for dynamics in ("aba", "rnea"))
    assert np.abs(aba - rnea).max() <= 1e-9 * np.abs(rnea).max()


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("links", [1, 4, 10])
def test_whole_runs_by_aba_and_rnea_are_equal(links, placement):
    scenario = step_scenario(ArmSpecification(links=links, placement=placement), 1.0, duration=1.0)
    aba, rnea = (simulate(scenario, dynamics=dynamics).trajectory for dynamics in ("aba", "rnea"))
    np.testing.assert_allclose(aba.joint_angles, rnea.joint_angles, rtol=0, atol=1e-9)
    np.testing.assert_allclose(aba.positions, rnea.positions, rtol=0, atol=1e-9)


def test_a_whole_run_is_that_of_euler_and_lagrange():
    arm = ArmSpecification(links=2, placement="mid", mount="horizontal", tip_mass=0.05, tilt=0.3)
    start, time = np.array([0.4, -0.1]), np.arange(31) * 0.01
    equations, numbers = lagrange(2), numbers_of(arm, 0.5)

    def slope(_, y):
        return np.concatenate([y[2:], np.linalg.solve(*equations(y[:2], y[2:], numbers)).ravel()])

    exact = solve_ivp(slope, time[[0, -1]], [*start, 0, 0], "Radau", time, rtol=1e-9, atol=1e-11).y[:2].T
    run = simulate(Scenario(arm, time, np.full(31, 0.5), Pose(start)), step=5e-4)
    np.testing.assert_allclose(run.trajectory.joint_angles, exact, rtol=0, atol=2e-8)


def test_several_models_in_one_batch_keep_to_their_columns():
    arms = [ArmSpecification(links=3, tip_mass=mass) for mass in (0.0, 0.0, 0.1, 0.05, 0.05)]
    q, v = motion(3, len(arms))
    scenarios = [Scenario(arm, [0.0, 0.01], [0.0, 0.0]) for arm in arms]
    models = [arm.model for arm in Columns(scenarios, shape_of(scenarios[0], 0.01)).arm_models]
    together = forward_dynamics("aba", models, [np.full(3, 0.01)]).solve(0, q, v, q)
    for b, model in enumerate(models):
        column = [np.asfortranarray(x[:, b : b + 1]) for x in (q, v, q)]
        np.testing.assert_array_equal(
            forward_dynamics("aba", [model], [np.full(3, 0.01)]).solve(0, *column)[:, 0], together[:, b]
        )


def test_the_shared_model_keeps_no_armature():
    arm = ArmSpecification(links=3)
    (arm_model,) = Columns([Scenario(arm, [0, 1], [0, 0])], shape_of(Scenario(arm, [0, 1], [0, 0]), 1.0)).arm_models
    forward_dynamics("aba", [arm_model.model], [np.ones(3)])
    assert np.all(arm_model.model.armature == 0)


def test_an_unknown_dynamics_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="expected aba or rnea, got 'lagrange'"):
        forward_dynamics("lagrange", [], [])


class DoublePendulum:
    """example-robot-data's double pendulum with a spring and a damper at each joint, as a Chain."""

    k, c = 2.0, 0.05

    def __init__(self, dynamics, lengths):
        path = next(f for f in files("example-robot-data") if f.name == "double_pendulum.urdf")
        self.model = pin.buildModelFromUrdf(str(path.locate()))
        self.stiffness, self.damping = np.full((2, 1), self.k), np.full((2, 1), self.c)
        self.work = workspace(lengths, links=2, columns=1)
        armatures = [(d * self.damping + d * d * self.stiffness)[:, 0] for d in lengths]
        self.forward = forward_dynamics(dynamics, [self.model], armatures)

    def force(self, q, v):
        return -self.k * q - self.c * v

    def solve(self, first, after, push=None):
        q, v, d = self.work[first]
        f = self.force(q, v) - d * self.k * v
        f = f if push is None else f + push
        return np.array([self.forward.solve(first + s, *x) for s, x in enumerate(zip(q, v, f, strict=True))])


def pendulum_run(method, dynamics, steps, duration=0.5):
    step = duration / steps
    chain = DoublePendulum(dynamics, method.lengths(step))
    q, v = np.asfortranarray([[1.0], [-0.5]]), np.zeros((2, 1), order="F")
    for _ in range(steps):
        q, v = method.advance(chain, q, v, step)
    return np.concatenate([q, v]).ravel()


@pytest.fixture(scope="module")
def pendulum_exact():
    chain = DoublePendulum("aba", ())
    data = chain.model.createData()

    def slope(_, y):
        return np.concatenate([y[2:], pin.aba(chain.model, data, y[:2], y[2:], chain.force(y[:2], y[2:]))])

    return solve_ivp(slope, [0, 0.5], [1.0, -0.5, 0, 0], "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def test_the_foreign_pendulum_moves_the_same_by_aba_and_rnea():
    aba, rnea = (pendulum_run(INTEGRATORS["extrapolated4"], dynamics, 50) for dynamics in ("aba", "rnea"))
    np.testing.assert_allclose(aba, rnea, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", INTEGRATORS)
def test_the_foreign_pendulum_converges_to_scipys_motion(name, pendulum_exact):
    method = INTEGRATORS[name]
    steps, slack = ((320, 640), 0.15) if method.order < 5 else ((160, 320), 0.3)  # more, and rounding would rule
    coarse, fine = (np.abs(pendulum_run(method, "aba", n) - pendulum_exact).max() for n in steps)
    assert np.log2(coarse / fine) >= method.order - slack
