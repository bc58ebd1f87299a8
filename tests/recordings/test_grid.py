"""Uneven samples are brought onto even instants; nothing is made up inside of a gap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr_pin.recordings.grid import even_grid, hold, instants_between, mean_until_next, on_even_grid, with_commands_between
from hsr_pin.recordings.read import read_dataset
from hsr_pin.trajectory import Marker, Trajectory


def wave(time):
    return np.stack([np.sin(3 * time), np.cos(2 * time)], axis=1)


def test_even_times_stay_as_they_are():
    assert even_grid(np.arange(300) / 120) is None


@pytest.mark.parametrize("rate, digits", [(120, 6), (360, 3), (100, 3), (119.88, 4), (480, 3), (1000 / 3, 3)])
@pytest.mark.parametrize("start", [0.0, 12.3456])
def test_times_rounded_to_their_last_digit_mean_the_even_grid_that_they_were_rounded_from(rate, digits, start):
    time = start + np.arange(2000) / rate
    written = np.round(time, digits)
    grid = even_grid(written)
    if grid is None:
        assert np.ptp(np.diff(written)) < 1e-7 / rate
        return
    assert len(grid.time) == 2000
    assert np.ptp(np.diff(grid.time)) < 1e-9 / rate
    assert np.abs(grid.time - time).max() <= 10.0**-digits
    values = wave(time)
    assert np.array_equal(grid.positions(values), values)


def test_rounded_times_with_rows_missing_keep_every_sample_at_its_instant():
    kept = np.delete(np.arange(5000), [5, 6, *range(100, 900), 3000])
    written = np.round(kept / 360, 3)
    grid = even_grid(written)
    values = grid.positions(wave(kept / 360))
    assert len(grid.time) == 5000
    assert np.array_equal(values[kept], wave(kept / 360))
    assert np.isnan(values[np.setdiff1d(np.arange(5000), kept)]).all()


def test_unix_times_count_from_the_first_sample():
    time = 1.7e9 + np.arange(3000) / 100
    grid = even_grid(np.round(time, 6))
    assert grid.origin == time[0]
    assert np.allclose(grid.time, np.arange(3000) / 100, atol=1e-6)
    assert np.ptp(np.diff(grid.time)) < 1e-9
    assert "are counted from the first sample, which was at 1700000000.000000 s" in grid.notes[-1]


@pytest.mark.parametrize("share", [0.003, 0.02, 0.2])
def test_jitter_is_counted_and_not_relabelled_away(share):
    rng = np.random.default_rng(1)
    time = (np.arange(1000) + rng.uniform(-share, share, 1000)) / 100
    speed = 3.0  # m/s: relabelled, a sample would be off by up to speed * share / 100
    grid = even_grid(time)
    inside = slice(2, 998)
    error = np.abs(grid.positions(speed * time[:, None])[:, 0] - speed * grid.time)[inside]
    assert np.nanmax(error) < 1e-9 < 0.5 * speed * share / 100
    assert np.isfinite(error).all()
    assert any("jitter" in note or "uneven" in note for note in grid.notes)


def test_slight_jitter_loses_no_sample_beside_a_gap():
    rng = np.random.default_rng(2)
    time = (np.arange(200) + rng.uniform(-0.004, 0.004, 200)) / 100
    values = wave(time)
    values[[50, 51, 120]] = np.nan
    placed = even_grid(time).positions(values)
    assert np.flatnonzero(np.isnan(placed[:, 0])).tolist() == [50, 51, 120]
    assert np.nanmax(np.abs(placed - wave(even_grid(time).time))) < 1e-5


def test_even_steps_are_left_as_they_are_to_the_last_bit(dataset):
    for trial in dataset.trials:
        assert on_even_grid(trial.trajectory)[0] is trial.trajectory


def test_missing_rows_become_gaps_at_their_own_instants():
    full = np.round(np.arange(2000) / 120, 6)
    kept = np.delete(np.arange(2000), [5, *range(100, 130), 1500])
    grid = even_grid(full[kept])
    assert len(grid.time) == 2000
    assert np.allclose(grid.time, full, atol=2e-5)
    values = grid.positions(wave(full[kept]))
    assert np.array_equal(np.isnan(values[:, 0]), ~np.isin(np.arange(2000), kept))
    assert np.array_equal(values[kept], wave(full[kept]))


def test_jitter_is_interpolated_away():
    rng = np.random.default_rng(0)
    time = np.arange(500) * 0.01 + rng.uniform(-0.003, 0.003, 500)
    grid = even_grid(time)
    assert np.ptp(np.diff(grid.time)) < 1e-12
    assert len(grid.time) in (499, 500, 501)
    assert np.nanmax(np.abs(grid.positions(wave(time)) - wave(grid.time))) < 4e-4
    assert np.isnan(grid.positions(wave(time))).mean() < 0.02


def test_a_missing_value_spreads_no_farther_than_the_instants_beside_it():
    time = np.arange(100) * 0.01 + 0.003 * (np.arange(100) % 2)
    values = wave(time)
    values[40] = np.nan
    missing = np.flatnonzero(np.isnan(even_grid(time).positions(values)[:, 0]))
    assert set(missing) <= {39, 40, 41}


def test_the_input_holds_until_its_next_value():
    time = np.delete(np.arange(10) * 0.1, [3, 4])
    held = even_grid(time).held(np.arange(10.0)[[0, 1, 2, 5, 6, 7, 8, 9]])
    assert np.array_equal(held, [0, 1, 2, 2, 2, 5, 6, 7, 8, 9])


def test_before_its_first_value_an_input_is_that_value():
    assert np.array_equal(hold(np.array([1.0, 2.0]), np.array([5.0, 6.0]), np.array([0.0, 1.5, 2.0])), [5, 5, 6])


def test_a_pause_that_would_be_almost_all_of_the_grid_is_refused():
    with pytest.raises(ValueError, match="would be gaps"):
        even_grid(np.array([0.0, 0.01, 0.02, 1e6]))


@given(st.lists(st.floats(1e-9, 10), min_size=1, max_size=40))
def test_any_increasing_times_give_an_even_grid_within_them_or_are_refused(steps):
    time = np.concatenate([[0.0], np.cumsum(steps)])
    time = time[np.concatenate([[True], np.diff(time) >= 1e-9])]
    if len(time) < 2:
        return
    try:
        grid = even_grid(time)
    except ValueError:
        return
    if grid is not None:
        assert grid.step > 0
        assert np.all(np.abs(np.diff(grid.time) - grid.step) <= 1e-9 + 1e-9 * grid.step)
        assert np.isfinite(grid.held(time)).all()
        inside = grid.positions(time[:, None])
        seen = np.isfinite(inside)
        assert np.all(np.abs(inside[seen] - grid.time[:, None][seen]) <= 0.02 * grid.step + 1e-9)


def test_a_recording_with_rows_missing_is_read_onto_an_even_grid_with_a_note(folder):
    path = folder / "trial_01.csv"
    lines = path.read_text(encoding="utf-8").split("\n")
    path.write_text("\n".join(lines[:6] + lines[9:]), encoding="utf-8")
    trajectory = read_dataset(folder).trials[0].trajectory
    assert len(trajectory.time) == 20
    assert np.flatnonzero(np.isnan(trajectory.positions[:, 1, 0])).tolist() == [5, 6, 7]
    assert np.array_equal(trajectory.torque, np.full(20, 0.5))
    assert len(trajectory.notes) == 1
    assert "resampled" in trajectory.notes[0]


def test_a_command_between_two_samples_keeps_its_time():
    frames = np.arange(9) / 4
    values, notes = mean_until_next(np.array([0.0, 1.01, 1.5]), np.array([[0.0], [2.0], [1.0]]), frames)
    assert values[:, 0] == pytest.approx([0, 0, 0, 0, 2 * 0.96, 2, 1, 1, 1])
    assert np.sum(values[:, 0]) / 4 == pytest.approx(2 * 0.49 + 0.75)  # what was given in all
    assert "changes between samples in 1 steps" in notes[0]
    exact, notes = mean_until_next(frames, np.arange(9.0)[:, None] / 7, frames)
    assert np.array_equal(exact[:, 0], np.arange(9.0) / 7) and notes == ()


def test_a_row_without_markers_between_even_samples_is_an_instant_of_the_command():
    time = np.insert(np.arange(9) / 4, 5, 1.01)
    places = np.insert(np.arange(9.0), 5, np.nan)
    raw = Trajectory(time, (Marker("tip", 1.0),), np.repeat(places, 3).reshape(10, 1, 3), torque=np.where(time > 1, 2.0, 0.0))
    even, _ = with_commands_between(raw, instants_between(raw))
    assert np.array_equal(even.time, np.arange(9) / 4) and np.array_equal(even.positions[:, 0, 0], np.arange(9.0))
    assert even.torque == pytest.approx([0, 0, 0, 0, 1.92, 2, 2, 2, 2])
    gaps = np.delete(time, 5)
    lost = Trajectory(gaps, raw.markers, np.where(gaps[:, None, None] == 1.0, np.nan, 1.0) * np.ones((9, 1, 3)), torque=0 * gaps)
    assert not instants_between(lost).any()  # a gap in even sampling is a gap


def test_a_command_that_stays_is_exact_where_another_changes_between_samples():
    source = np.array([0.0, 0.103, 0.247, 0.5])
    commands = np.array([[0.1, 1.1], [0.1, 0.3], [0.1, 2.7], [0.1, 2.7]])
    values, notes = mean_until_next(source, commands, np.arange(11) * 0.05)
    assert np.array_equal(values[:, 0], np.full(11, 0.1)) and notes
    assert values[2, 1] == pytest.approx((1.1 * 0.003 + 0.3 * 0.047) / 0.05)
