"""Closed loops and linear models against the simulation."""

import numpy as np

from hsr_pin.control.controllers import LQR, ComputedTorque, FeedforwardPD, OpenLoop, lqr_gain
from hsr_pin.control.reach import static_pose
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect
from hsr_pin.simulation.scenario import Pose
from hsr_pin.trajectory import Marker


def missed_distances(dynamics, reference, frequency, mean):
    """Return for each controller the RMS distance [m] of the tip from a reference, for an arm in space that is bent at rest.

    ``frequency`` is that of the computed torque [rad/s], ``mean`` the torque about which the LQR is linear.
    """
    laws = {
        "open": OpenLoop(reference),
        "pd": FeedforwardPD(dynamics, reference, 5.0, 0.05),
        "computed": ComputedTorque(dynamics, reference, frequency),
        "lqr": LQR(reference, lqr_gain(dynamics, mean, reference.step)),
    }
    bent = parse_effect("bend_at_rest:towards_x=0.15,towards_y=-0.2")
    plant, missed = ArmSimulator(dynamics.arm, (bent,), markers=(Marker("tip", 0.24),)), {}
    for name, law in laws.items():
        now, errors = plant.reset(pose=Pose(reference.q[0].reshape(-1, 3))), []
        for k in range(len(reference.time) - 1):
            now = plant.step(law.torque(k, now.angles, now.rates), dt=reference.step)
            errors.append(np.linalg.norm(plant.observe()[0] - reference.tip[k + 1]))
        missed[name] = np.sqrt(np.mean(np.square(errors)))
    return missed


def check_linear(dynamics, torque, dt=0.01):
    """Check that each torque moves the linear model as it moves the simulation, and return the model."""
    q0 = static_pose(dynamics, torque)
    step = dynamics.linearise(q0, torque).discrete(dt)
    simulator = ArmSimulator(dynamics.arm, step=1e-4)
    simulator.reset(pose=Pose(q0.reshape(-1, 3)))
    for du in 1e-3 * np.eye(len(torque)):
        after = simulator.advance(simulator.state, torque + du, dt)
        moved = np.concatenate([after.angles.ravel() - q0, after.rates.ravel()])
        np.testing.assert_allclose(moved, step.B @ du, atol=0.01 * np.abs(moved).max())
    return step
