"""A small dataset of an arm with a lag that nobody declared, and a page that shows it."""

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.trajectory import Dataset, Trajectory, Trial
from hsr_pin.view.session import Session

LAG = 0.08


@pytest.fixture(scope="session")
def lagging():
    """Two trials, 0.3 mm of noise; the tip is out of sight from 0.5 to 0.6 s."""
    noise, trials = np.random.default_rng(3), []
    arm = ArmSpecification(links=12, placement="mid")
    lag = (parse_effect(f"actuator_lag:time_constant={LAG}"),)
    for number, result in enumerate(
        simulate_batch([step_scenario(arm, tau, duration=1.0, effects=lag) for tau in (0.5, 0.9)]), 1
    ):
        motion = result.trajectory
        seen = motion.positions + 3e-4 * noise.standard_normal(motion.positions.shape)
        seen[(motion.time >= 0.5) & (motion.time <= 0.6), -1] = np.nan
        trials.append(
            Trial(f"trial_{number:02d}", Trajectory(motion.time, motion.markers, seen, torque=motion.torque), 1.11, 0.05)
        )
    return Dataset("lagging", arm.length, arm.mass, arm.diameter, arm.mount, tuple(trials))


@pytest.fixture(scope="session")
def session(lagging):
    return Session.of(lagging, 12, "mid")
