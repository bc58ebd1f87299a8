"""What arrives of a command is its exact mean over every cell, however long cells and steps are."""

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.command import CELL, Delivered, apply_compiled_law, deliver
from hsr_pin.simulation.integrate import mean_torque
from hsr_pin.simulation.scenario import Scenario

TIME = np.arange(9) * 0.02
TORQUE = np.array([0.0, 0.5, 0.5, -0.2, 0.1, 0.1, 0.1, 0.8, 0.8])


def batch(*effects, count=1):
    return ArmBatch.of([Scenario(ArmSpecification(), TIME, TORQUE, effects=effects)] * count)


def delivered(*effects, **how):
    return deliver(batch(*effects), TORQUE[:, None], np.zeros(1), 0.02, **how)


def test_a_held_command_is_its_own_mean_over_every_sample():
    command = delivered()
    assert (command.per_sample, command.cell) == (1, 0.02)
    np.testing.assert_allclose(np.diff(command.impulse[0]), TORQUE[:-1], atol=1e-15)


def test_an_interpolated_command_is_the_integral_of_the_straight_lines():
    command = delivered(interpolated=True)
    assert command.cell <= CELL + 1e-12
    fine = np.linspace(0, TIME[-1], 8 * 1000 + 1)
    line = np.interp(fine, TIME, TORQUE)
    integral = np.append(0.0, np.cumsum((line[1:] + line[:-1]) / 2) * np.diff(fine))
    ends = np.arange(command.impulse.shape[1]) * command.cell
    np.testing.assert_allclose(command.impulse[0] * command.cell, np.interp(ends, fine, integral), rtol=0, atol=1e-12)


@pytest.mark.parametrize("step", [0.005, 0.01, 0.0125, 0.02])
def test_small_changes_of_a_smooth_command_are_spread_about_their_instant_and_jumps_stay(step):
    time = np.arange(201) * step
    wave = 0.4 * np.sin(4 * np.pi * time)
    torque = wave + np.where(time < time[100], 0.0, 0.6)
    small, smooth = np.abs(np.diff(wave)).max(), deliver(batch(), torque[:, None], np.zeros(1), step, smooth=True)
    flow, held = np.diff(smooth.impulse[0]), np.repeat(torque[:-1], smooth.per_sample)
    jump = 100 * smooth.per_sample  # the cell with which it begins
    assert smooth.cell <= 0.0025 + 1e-12
    assert np.abs(flow - held).max() < small / 2
    changes = np.abs(np.diff(flow))
    assert changes[jump - 1] > 0.6 - small and np.delete(changes, jump - 1).max() < small / 2 + 1e-9
    assert np.abs(np.cumsum(flow - held)).max() * smooth.cell < small * 0.01 / 8 + 1e-12  # the integral comes back every time
    assert set(smooth.until[0]) == {float(jump), float(len(flow))}


def test_steps_and_what_hardly_changes_are_no_curve():
    steps = delivered(smooth=True)
    assert (steps.per_sample, steps.jump) == (1, delivered().jump)
    np.testing.assert_array_equal(steps.impulse, delivered().impulse)
    short = deliver(batch(), np.array([[0.0], [0.5]]), np.zeros(1), 0.02, smooth=True)
    assert short.impulse.shape == (1, 2)


def test_the_mean_over_any_part_of_cells_is_that_of_the_integral():
    impulse, mean = delivered().impulse, np.zeros(1)
    for start, end in ((0.0, 1.0), (0.25, 0.75), (0.5, 3.25), (7.5, 8.0), (0.0, 8.0)):
        mean_torque(impulse, start, end, mean)
        parts = 44 * 100  # whole cells and quarters fall between them
        middles = start + (end - start) * (np.arange(parts) + 0.5) / parts
        expected = TORQUE[middles.astype(int)].mean()
        assert mean[0] == pytest.approx(expected, abs=1e-12)


def test_no_step_may_pass_a_jump_and_small_changes_are_passed():
    assert delivered().until[0].tolist() == [1.0, 3.0, 3.0, 4.0, 7.0, 7.0, 7.0, 8.0, 8.0]
    slow = deliver(batch(), 0.5 + 1e-3 * np.arange(9)[:, None], np.zeros(1), 0.02)
    assert set(slow.until[0]) == {8.0}


def test_what_one_column_hears_late_the_others_do_not():
    late = [
        Scenario(ArmSpecification(), TIME, TORQUE, effects=(parse_effect(f"dead_time:delay={d}"),)) for d in (0.0, 0.02, 0.03)
    ]
    given = deliver(ArmBatch.of(late), TORQUE[:, None], np.zeros(1), 0.02)
    means = np.diff(given.impulse, axis=1).reshape(len(late), len(TORQUE) - 1, given.per_sample).mean(axis=2)
    np.testing.assert_allclose(means[0], TORQUE[:-1], atol=1e-14)
    np.testing.assert_allclose(means[1], [0.0, *TORQUE[:-2]], atol=1e-14)
    np.testing.assert_allclose(means[2], np.add([0.0, *TORQUE[:-2]], [0.0, 0.0, *TORQUE[:-3]]) / 2, atol=1e-14)


def test_a_delay_of_part_of_a_sample_leaves_jumps_as_steep_as_they_were():
    late = Scenario(ArmSpecification(), TIME, TORQUE, effects=(parse_effect("dead_time:delay=0.015"),))
    given = deliver(ArmBatch.of([late]), TORQUE[:, None], np.zeros(1), 0.02)
    np.testing.assert_allclose(np.diff(given.impulse)[0], [*[0.0] * 3, *np.repeat(TORQUE[:-1], 4)[:-3]], atol=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "actuator_lag:time_constant=0.05",
        "torque_bias:bias=0.2",
        "torque_map:quadratic=0.4",
        "torque_map:quadratic=0.4,parity=even",
    ],
)
def test_machine_code_makes_of_a_command_what_the_law_makes(text):
    law = parse_effect(text)
    slow, fast = (
        deliver(batch(law, count=3), TORQUE[:, None], np.zeros(1), 0.02, apply_law=way) for way in (None, apply_compiled_law)
    )
    np.testing.assert_allclose(fast.impulse, slow.impulse, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(fast.initial, slow.initial)


def test_muscles_act_in_the_order_in_which_they_are_given():
    bias, double = parse_effect("torque_bias:bias=0.3"), parse_effect("torque_map:quadratic=0.5")
    first, second = delivered(bias, double).impulse, delivered(double, bias).impulse
    assert np.abs(first - second).max() > 0.01


def test_a_torque_beside_what_arrives_is_passed_on_by_no_muscle():
    """It is there before the first sample too; in space it is towards both sides, the same for each section."""
    plain = deliver(batch(parse_effect("actuator_lag:time_constant=0.05"), count=2), TORQUE[:, None], np.zeros(1), 0.02)
    more = plain.with_torque(np.array([0.1, -0.3]))
    per_cell = np.diff(more.impulse - plain.impulse, axis=1)
    np.testing.assert_allclose(per_cell, np.broadcast_to([[0.1], [-0.3]], per_cell.shape), atol=1e-13)
    np.testing.assert_allclose(more.initial - plain.initial, [0.1, -0.3])
    first = plain.with_torque_between(np.array([0.1, -0.3]), 0.02, 0.03)
    early = np.zeros(per_cell.shape[1])
    early[round(0.02 / plain.cell) : round(0.03 / plain.cell)] = 1
    np.testing.assert_allclose(np.diff(first.impulse - plain.impulse, axis=1), [0.1 * early, -0.3 * early], atol=1e-13)
    np.testing.assert_array_equal(first.initial, plain.initial)
    of_two_sections = Delivered(np.zeros((1, 4, 4)), 0.01, 1, np.zeros((1, 4))).with_torque(np.array([0.1 - 0.3j]))
    np.testing.assert_allclose(of_two_sections.initial, [[0.1, -0.3, 0.1, -0.3]])
    np.testing.assert_allclose(of_two_sections.impulse[0, 3], [0.3, -0.9, 0.3, -0.9])
