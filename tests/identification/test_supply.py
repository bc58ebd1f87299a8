"""The supply between a command and what was measured is found from series that scipy.signal simulates, with honest intervals."""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

from hsr_pin.identification.supply import identify_supply, supplies
from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

#: Times [s] at which a command changes, and what it changes to.
INSTANTS = np.array([1.0, 4.2, 7.9, 12.1, 16.4, 20.0])
LEVELS = np.array([0.0, 2.0, 0.5, 1.5, 0.8, 2.2, 0.0])
FINE = 1e-3


def delivered(time, supply, instants=INSTANTS, levels=LEVELS):
    """The value (T,) that a supply (delay, rise, fall, gain, offset) delivers, one linear system for each constant command."""
    delay, rise, fall, gain, offset = supply
    fine = np.arange(0, time[-1] + 2 * FINE, FINE)
    edges = np.concatenate([[0.0], instants + delay, [fine[-1] + FINE]])
    value, state = np.empty_like(fine), gain * levels[0] + offset
    for level, begin, end in zip(levels, edges[:-1], edges[1:], strict=True):
        inside = (fine >= begin) & (fine < end)
        if not inside.any():
            continue
        constant, target = (rise if gain * level + offset > state else fall), gain * level + offset
        system = StateSpace([[-1 / constant]], [[1 / constant]], [[1.0]], [[0.0]])
        own = np.concatenate([[0.0], fine[inside] - begin, [end - begin]])
        _, y, _ = lsim(system, np.full(len(own), target), np.linspace(0, own[-1], len(own)), X0=[state], interp=False)
        value[inside] = np.interp(fine[inside] - begin, np.linspace(0, own[-1], len(own)), y)
        state = float(y[-1])
    return np.interp(time, fine, value)


def commanded(time, instants=INSTANTS, levels=LEVELS):
    return levels[np.searchsorted(instants, time + 1e-9, side="right")]


def series(supply, rng, *, step=0.01, noise=0.02, seconds=24.0, shift=0.0):
    """Times, command and measured value; the true instants of the command are ``shift`` before those of the log."""
    time = np.arange(0, seconds, step)
    instants = np.ceil(INSTANTS / step) * step - shift
    value = delivered(time, supply, instants)
    return time, commanded(time, np.ceil(INSTANTS / step) * step), value + noise * rng.normal(size=len(time))


TRUE = (0.24, 0.57, 1.08, 0.95, 0.1)


def numbers(found):
    return [each.value for each in found.estimates]


def test_delay_and_both_time_constants_are_found():
    found = identify_supply([series(TRUE, np.random.default_rng(0))], "P1", "bar")
    assert numbers(found) == pytest.approx(TRUE, rel=0.03, abs=0.01)
    assert found.is_late
    assert found.rms == pytest.approx(0.02, rel=0.05)


def drawn(rng):
    return (
        rng.uniform(0.02, 0.4),
        *np.exp(rng.uniform(np.log(0.05), np.log(0.8), 2)),
        rng.uniform(0.8, 1.2),
        rng.uniform(-0.1, 0.1),
    )


def contained(step, noise, repeats, correlated=0.0, seed=5):
    """Whether the interval of each estimate contains the truth, one row for each draw."""
    rng, rows = np.random.default_rng(seed), []
    for _ in range(repeats):
        supply = drawn(rng)
        time, command, value = series(supply, rng, step=step, noise=0.0)
        errors = noise * rng.normal(size=len(time))
        for index in range(1, len(errors)):
            errors[index] += correlated * errors[index - 1]
        found = identify_supply([(time, command, value + errors)])
        inside = [each.interval[0] <= true <= each.interval[1] for each, true in zip(found.estimates, supply, strict=True)]
        rows.append(inside)
    return np.array(rows)


@pytest.mark.parametrize("step, noise, correlated", [(0.02, 0.02, 0.0), (0.1, 0.02, 0.0), (0.02, 0.01, 0.9)])
def test_intervals_contain_the_truth_as_often_as_they_state(step, noise, correlated):
    inside = contained(step, noise, 24, correlated)
    assert inside[:, 1:].mean() > 0.85
    assert inside[:, 0].mean() > 0.93  # the instants of the command are known to a sample only


def test_the_interval_of_a_delay_covers_commands_given_between_two_samples():
    rng, inside = np.random.default_rng(3), []
    for shift in np.linspace(0, 0.05, 12):
        found = identify_supply([series(TRUE, rng, step=0.05, noise=0.005, shift=shift)])
        inside.append(found.delay.interval[0] <= TRUE[0] + (0.0 - shift) + 0.05 and TRUE[0] - shift <= found.delay.interval[1])
    assert np.mean(inside) > 0.9


def test_a_sensor_that_repeats_its_last_value_is_read_at_its_new_values():
    rng = np.random.default_rng(1)
    time, command, value = series(TRUE, rng, step=0.01)
    repeating = value[(np.arange(len(value)) // 12) * 12]
    found = identify_supply([(time, command, repeating)])
    assert numbers(found) == pytest.approx(TRUE, rel=0.06, abs=0.03)


def test_values_at_another_rate_than_the_command_are_used_where_they_are():
    time, command, value = series(TRUE, np.random.default_rng(1), step=0.01)
    value = np.where(np.arange(len(value)) % 7 == 3, value, np.nan)
    assert numbers(identify_supply([(time, command, value)])) == pytest.approx(TRUE, rel=0.05, abs=0.02)


def test_several_recordings_that_begin_in_motion_are_fitted_together():
    time, command, value = series(TRUE, np.random.default_rng(2))
    parts = [(time[a:b], command[a:b], value[a:b]) for a, b in ((450, 1180), (1240, 1900), (1500, 2400))]
    assert numbers(identify_supply(parts)) == pytest.approx(TRUE, rel=0.05, abs=0.03)


def test_a_command_that_only_rises_leaves_the_fall_open():
    time, command, value = series(TRUE, np.random.default_rng(2), seconds=4.0)
    found = identify_supply([(time, command, value)])
    assert found.fall is None and found.rise.value == pytest.approx(0.57, rel=0.1)
    assert "falls" not in str(found)


def test_without_a_change_of_command_there_is_no_supply():
    time = np.arange(100) / 100
    assert identify_supply([(time, 0 * time, np.sin(time))]) is None


def test_a_supply_that_follows_at_once_is_not_late():
    time = np.arange(0, 24, 0.02)
    value = commanded(time) + 0.01 * np.random.default_rng(0).normal(size=len(time))
    found = identify_supply([(time, commanded(time), value)])
    assert not found.is_late
    assert str(found) == "follows within a sample (0.0200 s)"


def test_another_law_is_stated_as_one():
    """A second-order supply that rings is neither a delay nor a lag of first order."""
    time = np.arange(0, 24, 0.01)
    _, value, _ = lsim(([16.0], [1.0, 0.8, 16.0]), commanded(time), time)
    found = identify_supply([(time, commanded(time), value)])
    assert "follows another law" in str(found)


@pytest.fixture
def dataset():
    """Two trials of an arm whose pressures were recorded as commanded and as measured; P2 is never driven."""
    rng, trials = np.random.default_rng(0), []
    for name in ("one", "two"):
        time, command, value = series(TRUE, rng)
        positions = np.zeros((len(time), 1, 3))
        pair = [np.stack([each, 0 * each], axis=1) for each in (value, command)]
        trajectory = Trajectory(time, (Marker("tip", 0.24),), positions, pressures=pair[0], commanded=pair[1])
        trials.append(Trial(name, trajectory, 1.11))
    return Dataset("arm", 0.24, 0.15, 0.04, "hanging", tuple(trials))


def test_the_channels_of_a_dataset_that_are_driven_are_identified(dataset):
    (found,) = supplies(dataset)
    assert (found.name, found.unit) == ("P1", "bar")
    assert numbers(found) == pytest.approx(TRUE, rel=0.03, abs=0.01)


def test_a_command_that_is_constant_up_to_rounding_is_not_driven():
    time, _, value = series(TRUE, np.random.default_rng(2))
    constant = 1.5 + 1e-13 * np.random.default_rng(2).normal(size=len(time))
    assert identify_supply([(time, constant, value)]) is None
