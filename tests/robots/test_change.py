"""Known edits of real recordings are found as what has changed between two sessions of a double pendulum."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.robots import explain_robot_change, read_robot
from hsr_pin.robots.model import RobotModel

pytestmark = pytest.mark.long

#: The most probable model of the recordings (`hsr-diagnose double-pendulum`), which is not fitted again for every edit.
KNOWN = {
    "link_inertia.Joint1": -0.944,
    "link_inertia.Joint2": -0.848,
    "coulomb_friction.Joint1": 0.189,
    "coulomb_friction.Joint2": 0.1527,
}


@pytest.fixture(scope="module")
def recordings():
    return read_robot("double-pendulum")


def changed(recordings, position=lambda trial: trial.position, command=lambda trial: trial.command):
    """Return what has changed if the recorded angles and commands of every trial are edited."""
    edited = tuple(replace(trial, position=position(trial), command=command(trial)) for trial in recordings.trials)
    known = RobotModel.of(recordings).neutral | KNOWN
    later = replace(recordings, trials=edited)
    return explain_robot_change(later, recordings, seconds=0.25, known=known, max_causes=1)


def names(found):
    """Return all names that a verdict gives, alone or as alternatives."""
    return {name for group in (found.verdict.effects, *found.verdict.alternatives) for name in group}


def test_an_unchanged_robot_is_reported_as_unchanged(recordings):
    assert changed(recordings).verdict.status == "unchanged"


def test_a_base_that_is_turned_cannot_be_told_from_an_encoder_that_is_turned(recordings):
    found = changed(recordings, position=lambda trial: trial.position + np.array([np.radians(3.0), 0.0]))
    assert names(found) == {"encoder_offset", "tilted_base"}


def test_an_encoder_that_is_scaled_is_named(recordings):
    found = changed(recordings, position=lambda trial: trial.position * [1.0, 1.02])
    assert names(found) == {"encoder_gain"}
    assert found.values["encoder_gain.Joint2"] == pytest.approx(0.02, rel=0.05)


def test_another_torque_constant_is_named(recordings):
    found = changed(recordings, command=lambda trial: trial.command / [1.1, 1.0])
    assert names(found) == {"torque_gain"}
    assert found.values["torque_gain.Joint1"] == pytest.approx(0.1, rel=0.05)


def test_commands_that_act_later_are_named(recordings):
    def earlier(trial):
        return np.column_stack([np.interp(trial.time + 0.02, trial.time, column) for column in trial.command.T])

    found = changed(recordings, command=earlier)
    assert names(found) == {"dead_time"}
    assert found.values["dead_time.delay"] == pytest.approx(0.02, rel=0.05)
