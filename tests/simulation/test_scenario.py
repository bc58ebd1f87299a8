"""A scenario refuses what cannot be simulated, by name."""

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario

ARM = ArmSpecification(links=2)


@pytest.mark.parametrize(
    ("time", "torque", "subject"),
    [
        ([0.0], [0.0], "time"),
        ([0.0, np.nan], [0.0, 0.0], "time"),
        ([0.0, 0.1, 0.3], [0.0, 0.0, 0.0], "time"),
        ([0.1, 0.0], [0.0, 0.0], "time"),
        ([0.0, 0.1], [0.0], "torque"),
        ([0.0, 0.1], [0.0, np.inf], "torque"),
    ],
)
def test_times_and_torques_must_be_finite_and_even(time, torque, subject):
    with pytest.raises(InputError) as refused:
        Scenario(ARM, time, torque)
    assert refused.value.subject == subject


def test_a_pose_needs_an_angle_for_each_joint():
    with pytest.raises(InputError, match="expected 2 joint angles"):
        Scenario(ARM, [0.0, 0.1], [0.0, 0.0], Pose(np.zeros(3)))


@pytest.mark.parametrize(("angles", "rates"), [([0.0, 0.0], [1.0]), ([np.nan, 0.0], None), ([0.0, 0.0], [0.0, np.inf])])
def test_a_pose_must_be_finite_and_have_as_many_rates_as_angles(angles, rates):
    with pytest.raises(InputError, match="as many finite rates"):
        Pose(angles, rates)


def test_a_start_under_an_infinite_torque_is_refused():
    with pytest.raises(InputError, match="a finite torque"):
        Settled(np.inf)


def test_what_a_scenario_was_given_cannot_be_changed_through_it():
    scenario = Scenario(ARM, np.arange(3.0), np.zeros(3))
    with pytest.raises(ValueError, match="read-only"):
        scenario.torque[0] = 1.0


def test_a_step_scenario_rests_and_then_holds_its_torque():
    scenario = step_scenario(ARM, 2.0, rest=0.1, duration=0.2, step=0.05)
    np.testing.assert_array_equal(scenario.torque, [0, 0, 2, 2, 2])


def test_the_markers_are_base_middle_and_tip_unless_told():
    assert [(m.name, m.arc_length) for m in step_scenario(ARM, 0.0).markers] == [("base", 0.0), ("mid", 0.12), ("tip", 0.24)]


@pytest.mark.parametrize(
    ("time", "said"),
    [
        (np.array([0.0, 1e9]), "at most 86400 s"),
        (np.arange(5) * 1e7, "these may be milliseconds"),
    ],
)
def test_times_that_no_run_can_have_are_refused_before_anything_is_computed(time, said):
    with pytest.raises(InputError, match=said):
        Scenario(ArmSpecification(), time, np.zeros(len(time)))


@pytest.mark.parametrize("asked", [{"step": 0.0}, {"step": -0.01}, {"step": 1e-12}, {"duration": 1e9}, {"duration": np.nan}])
def test_a_step_or_a_duration_that_cannot_be_is_refused_before_an_array_is_made(asked):
    with pytest.raises(InputError, match="duration"):
        step_scenario(ArmSpecification(), 1.0, **asked)
