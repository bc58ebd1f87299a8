"""Independent references for the simulation: they share the Pinocchio model with it and nothing else."""

import dataclasses
import itertools

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

import hsr_pin.robot.chain as chain_module
import hsr_pin.simulation.arm_batch as batch_module
from hsr_pin.robot.model import build_model


@pytest.fixture(scope="session")
def exact_motion():
    """Give ``exact_motion(scenario, q, v)``: (T, 2N) angles [rad] and rates [rad/s].

    By SciPy's Radau at 1e-10, restarted at every change of the input.
    """
    return _exact_motion


def _exact_motion(scenario, q, v=None, tolerance=1e-10):
    arm = scenario.arm
    model = build_model(arm).model
    data, n = model.createData(), arm.links
    k, c = n * arm.keq, n * arm.damping

    def rhs(torque):
        def slope(_, y):
            q, v = y[:n], y[n:]
            return np.concatenate([v, pin.aba(model, data, q, v, torque - k * q - c * v)])

        return slope

    def jacobian(torque):
        def matrix(_, y):
            q, v = y[:n], y[n:]
            da_dq, da_dv, inverse = pin.computeABADerivatives(model, data, q, v, torque - k * q - c * v)
            lower, upper = np.triu(inverse, 1).T, np.triu(inverse)
            inverse = lower + upper
            return np.block([[np.zeros((n, n)), np.eye(n)], [da_dq - k * inverse, da_dv - c * inverse]])

        return matrix

    state = np.concatenate([q, np.zeros(n) if v is None else v])
    states = [state]
    changes = [0, *(np.flatnonzero(np.diff(scenario.torque[:-1])) + 1), len(scenario.time) - 1]
    for start, stop in itertools.pairwise(changes):
        times, torque = scenario.time[start : stop + 1], scenario.torque[start]
        run = solve_ivp(
            rhs(torque), times[[0, -1]], state, "Radau", times, jac=jacobian(torque), rtol=tolerance, atol=tolerance * 1e-2
        )
        assert run.success
        states += list(run.y.T[1:])
        state = run.y[:, -1]
    return np.array(states)


@pytest.fixture
def weightless(monkeypatch):
    """Switch gravity off in all arms that are simulated, on both ways."""

    def build(specification):
        arm = build_model(specification)
        model = arm.model.copy()
        model.gravity = pin.Motion.Zero()
        return dataclasses.replace(arm, model=model)

    monkeypatch.setattr(batch_module, "build_model", build)
    monkeypatch.setattr(chain_module, "GRAVITY", 0.0)
