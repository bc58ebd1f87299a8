"""Small errors of declared numbers are no gap, and larger ones remain one."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.explain.recordings import ExtendedModel, Recordings
from hsr_pin.inference.candidate import candidate
from hsr_pin.inference.fit import fit
from hsr_pin.robots import Robot, RobotRecordings, RobotTrial
from hsr_pin.robots.causes import CAUSES
from hsr_pin.robots.model import RobotModel
from hsr_pin.robots.simulation import Case, Stretch, simulate
from tests.robots.test_simulation import JOINTS, URDF

STEP = 0.004
TIME = np.arange(0, 1.5, STEP)
NOISE = 1e-4


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    file = tmp_path_factory.mktemp("robot") / "robot.urdf"
    file.write_text(URDF, encoding="utf-8")
    return Robot.load(file, JOINTS, [0.01, 0.02])


def recorded(robot, late=0.0, **true):
    """Return recordings of a robot whose true numbers differ from the declared ones, and whose commands act late [s]."""
    rng, trials = np.random.default_rng(0), []
    commands = [np.column_stack([a * np.sin(b * TIME), 2 * np.cos(a * b * TIME)]) for a, b in ((0.6, 7), (0.4, 4), (0.8, 5))]
    still = RobotTrial("still", TIME, np.column_stack([TIME, TIME]), commands[0])
    model = RobotModel.of(RobotRecordings("robot", robot, (still,)))
    values = model.neutral | {name.replace("__", "."): value for name, value in true.items()}
    for number, command in enumerate(commands):
        acting = np.column_stack([np.interp(TIME - late, TIME, column) for column in command.T])
        start = Stretch(TIME, acting, TIME[:2] - 1, 0 * acting[:2], np.array([0.3, -0.2]), np.zeros(2), np.zeros(2), True)
        (angle,) = simulate(robot, CAUSES, model.neutral, model.scales, [Case(start, values)])
        trials.append(RobotTrial(f"trial {number}", TIME, angle + NOISE * rng.normal(size=angle.shape), command))
    return RobotRecordings("robot", robot, tuple(trials))


def gap(recordings, accuracy):
    """Return the RMS gap without causes [floors], and the sum of the squared errors of declared numbers."""
    robot = replace(recordings.robot, accuracy=accuracy)
    model = RobotModel.of(replace(recordings, robot=robot))
    stretches = Recordings(model.as_model, model.trials(0.25))
    found = candidate(stretches, fit(stretches, ExtendedModel(stretches.model)), {}).model
    return np.sqrt(found.misfit), float(np.sum(found.errors**2))


def test_a_link_that_is_slightly_heavier_than_declared_is_no_gap(robot):
    recordings = recorded(robot, link_mass__elbow=0.02)
    without, (left, errors) = gap(recordings, 0.0), gap(recordings, 0.02)
    assert without[0] > 2 and left < 0.5 * without[0]
    assert 0 < errors < 4


def test_friction_is_not_taken_for_an_error_of_a_declared_number(robot):
    recordings = recorded(robot, coulomb_friction__elbow=0.2)
    without, (left, _) = gap(recordings, 0.0), gap(recordings, 0.02)
    assert left > 0.5 * without[0] > 5


def test_a_delay_below_one_sampling_interval_is_no_gap_and_a_longer_one_is(robot):
    shorter, longer = (gap(recorded(robot, late), 0.02)[0] for late in (0.5 * STEP, 5 * STEP))
    assert longer > 3 * shorter
