"""What is said about a tip's path equals what is known of it: closed forms of second-order motion, and exact curves."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.measures import first_self_contact, measure_tip, nearest_circle
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker, Trajectory

TIME = np.linspace(0.0, 3.0, 301)
STEP = 0.2


def motion(share, time=TIME, step=STEP, way=(0.06, 0.08)):
    """A tip that goes ``share(time since the step)`` of a way of 0.1 m, and its command."""
    elapsed = np.maximum(time - step, 0.0)
    moved = np.where(time >= step - 1e-9, share(elapsed), 0.0)
    positions = np.zeros((len(time), 1, 3))
    positions[:, 0, 0], positions[:, 0, 2] = way[0] * moved, way[1] * moved - 0.24
    return Trajectory(time, (Marker("tip", 0.24),), positions, torque=np.where(time < step - 1e-9, 0.0, 1.0))


def second_order(damping_ratio, frequency=20.0):
    root = np.sqrt(1 - damping_ratio**2)

    def share(t):
        turn = root * frequency * t
        return 1 - np.exp(-damping_ratio * frequency * t) * (np.cos(turn) + damping_ratio / root * np.sin(turn))

    return share


def test_the_settled_tip_is_where_it_ends():
    measures = measure_tip(motion(second_order(0.5)))
    assert (measures.x, measures.z) == pytest.approx((0.06, -0.16), abs=1e-9)


@pytest.mark.parametrize("damping_ratio", [0.2, 0.4, 0.6])
def test_overshoot_is_that_of_a_second_order_motion(damping_ratio):
    closed_form = np.exp(-np.pi * damping_ratio / np.sqrt(1 - damping_ratio**2))
    fine = np.linspace(0.0, 3.0, 30001)
    assert measure_tip(motion(second_order(damping_ratio), fine)).overshoot == pytest.approx(closed_form, abs=1e-5)


def test_settling_time_of_a_first_order_motion_is_its_time_constant_times_log_50():
    assert measure_tip(motion(lambda t: 1 - np.exp(-t / 0.1))).settling_time == pytest.approx(0.1 * np.log(50), abs=2e-4)


def test_settling_time_of_an_oscillation_is_its_last_entry_into_the_band():
    share = second_order(0.2)
    fine = np.linspace(0, 3, 300001)
    last_outside = fine[np.flatnonzero(np.abs(share(fine) - 1) > 0.02)[-1]]
    exact = brentq(lambda t: abs(share(t) - 1) - 0.02, last_outside - 1e-3, last_outside + 1e-3)
    assert measure_tip(motion(share)).settling_time == pytest.approx(exact, abs=1e-3)


def test_time_counts_from_the_last_change_of_the_command():
    first = motion(lambda t: 1 - np.exp(-t / 0.05))
    second = motion(lambda t: 1 - np.exp(-t / 0.1), step=1.5)
    both = dataclasses.replace(first, positions=first.positions + second.positions, torque=first.torque + second.torque)
    assert measure_tip(both).settling_time == pytest.approx(0.1 * np.log(50), abs=1e-3)


def test_pressures_are_a_command_too():
    by_torque = motion(lambda t: 1 - np.exp(-t / 0.1), step=1.0)
    pressures = np.stack([by_torque.torque, 2 - by_torque.torque], axis=1)
    by_pressures = dataclasses.replace(by_torque, torque=None, pressures=pressures)
    assert measure_tip(by_pressures) == measure_tip(by_torque)


@pytest.mark.parametrize(
    "share", [lambda t: np.sin(9 * t), lambda t: t, second_order(0.01)], ids=["swinging", "creeping", "ringing"]
)
def test_an_arm_still_in_motion_has_not_settled(share):
    measures = measure_tip(motion(share))
    assert not measures.settled
    assert measures.overshoot is None


def test_a_tip_that_does_not_move_has_settled_and_has_no_circle():
    measures = measure_tip(motion(lambda t: 0 * t))
    assert (measures.settling_time, measures.overshoot, measures.circle) == (0.0, 0.0, None)


def test_samples_in_which_the_tip_was_not_seen_are_left_out():
    whole = motion(lambda t: 1 - np.exp(-t / 0.1))
    positions = whole.positions.copy()
    positions[100:120] = np.nan
    seen, every = measure_tip(dataclasses.replace(whole, positions=positions)), measure_tip(whole)
    assert (seen.x, seen.z, seen.overshoot) == (every.x, every.z, every.overshoot)
    assert seen.settling_time == pytest.approx(every.settling_time, abs=1e-9)


@pytest.mark.parametrize("span", [0.05, 1.0, 2.5, 4.0, 5.5])
@pytest.mark.parametrize("start", [0.0, 2.0, -1.3])
def test_the_circle_of_an_arc_is_found_exactly(span, start):
    turn = start + span * np.linspace(0, 1, 40) ** 2
    circle = nearest_circle(np.c_[3 + 0.2 * np.cos(turn), -1 + 0.2 * np.sin(turn)])
    assert circle.radius == pytest.approx(0.2, rel=1e-6)
    assert circle.distance < 1e-12


def test_a_straight_path_is_a_circle_without_end():
    way = np.linspace(0, 0.1, 30)
    circle = nearest_circle(np.c_[way, 2 * way - 1])
    assert circle.radius > 1e6
    assert circle.distance < 1e-12


def test_the_distance_is_the_known_one_of_two_concentric_circles():
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    waves = 0.2 + 0.001 * np.sign(np.sin(20 * turn + 1e-3))
    circle = nearest_circle(np.c_[waves * np.cos(turn), waves * np.sin(turn)])
    assert circle.distance == pytest.approx(0.001, rel=0.01)


def test_a_long_rest_at_the_end_weighs_nothing():
    turn = np.linspace(0, 1.5, 60)
    path = np.c_[0.24 * np.sin(turn) * 0.9, -0.24 * np.cos(turn)]  # an ellipse
    resting = np.concatenate([path, np.repeat(path[-1:], 500, axis=0)])
    assert nearest_circle(resting).distance == pytest.approx(nearest_circle(path).distance, rel=1e-9)
    assert nearest_circle(path).distance > 1e-4


def test_a_single_point_has_no_circle():
    assert nearest_circle(np.ones((20, 2))) is None


@pytest.mark.parametrize("seed", range(40))
def test_the_nearest_circle_is_the_one_that_least_squares_finds(seed):
    generator = np.random.default_rng(seed)
    radius, span = 10 ** generator.uniform(-1.5, 0.5), generator.uniform(0.1, 6.0)
    angle = np.sort(generator.uniform(0.0, span, 200))
    path = radius * np.column_stack([np.cos(angle), np.sin(angle)]) + generator.normal(0.0, 0.02 * radius * span, (200, 2))
    pieces = np.linalg.norm(np.diff(path, axis=0), axis=1)
    weight = np.sqrt((np.append(pieces, 0.0) + np.append(0.0, pieces)) / (2 * pieces.sum()))
    ends = [
        least_squares(lambda c: weight * (np.hypot(*(path - c[:2]).T) - c[2]), (*(start * radius), radius))
        for start in (np.zeros(2), np.array([-2.0, 0.0]), np.array([3.0, 0.0]), np.array([0.0, 3.0]))
    ]
    best = min(ends, key=lambda end: end.cost)
    assert nearest_circle(path).distance <= (1 + 1e-3) * np.sqrt(2 * best.cost)


@pytest.mark.parametrize("bending", ["plane", "space"])
def test_an_arm_that_passes_through_itself_is_told(bending):
    arm = ArmSpecification(links=16, placement="mid", bending=bending, bending_limit=20.0, keq=0.3, mass=0.01)
    curled = simulate(step_scenario(arm, 2.2, duration=1.0))  # more than a whole turn
    bent = simulate(step_scenario(arm, 0.5, duration=1.0))
    assert first_self_contact(arm, bent.trajectory) is None
    time = first_self_contact(arm, curled.trajectory)
    assert time is not None and 0.1 < time < 1.0
    assert "passes through itself" in curled.warning and bent.warning == ""
