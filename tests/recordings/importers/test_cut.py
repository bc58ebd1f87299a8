"""One long recording is divided into trials, where the arm rests or at given times."""

from pathlib import Path

import numpy as np
import pytest

from hsr_pin.cli.import_ import command
from hsr_pin.errors import InputError
from hsr_pin.recordings.importers.cut import cut
from hsr_pin.recordings.read import read_dataset
from hsr_pin.trajectory import Marker, Trajectory

STEP = 0.01
#: Times at which the torque changes [s]: the arm swings for two seconds after each, and rests then.
CHANGES = (1.0, 6.0, 11.0, 16.0)


def recording(noise=1e-4, changes=CHANGES):
    time = np.arange(0, 21, STEP)
    torque = sum(((-1) ** k) * (time >= at) * 0.5 for k, at in enumerate(changes))
    x = np.zeros(len(time))
    for k, at in enumerate(changes):
        since = np.maximum(time - at, 0)
        x += ((-1) ** k) * (time >= at) * 0.05 * (1 - np.exp(-3 * since) * np.cos(9 * since))
    positions = np.stack([x, 0 * x, -0.24 + x**2], axis=1)[:, None]
    positions = positions + noise * np.random.default_rng(3).normal(size=positions.shape) * [1, 0, 1]
    return Trajectory(time, (Marker("tip", 0.24),), positions, torque)


def test_trials_begin_at_rest_shortly_before_each_motion():
    whole = recording()
    parts = cut(whole, "auto", Path("take.csv"))
    assert len(parts) == len(CHANGES)
    assert sum(len(part.time) for part in parts) == len(whole.time)
    for part in parts:
        moved = np.flatnonzero(np.diff(part.torque))
        assert part.time[0] == 0 and len(moved) == 1
        assert np.ptp(part.positions[: moved[0], 0, 0]) < 2e-3  # at rest until the torque changes


def test_a_gap_in_a_marker_is_not_a_motion():
    whole = recording()
    gaps = np.array(whole.positions)
    gaps[400:450] = np.nan
    again = Trajectory(whole.time, whole.markers, gaps, whole.torque)
    assert len(cut(again, "auto", Path("take.csv"))) == len(CHANGES)


def test_a_single_motion_is_one_trial():
    (part,) = cut(recording(changes=(3.0,)), "auto", Path("take.csv"))
    assert len(part.time) == len(recording().time)


def test_given_times_are_used_as_they_are():
    parts = cut(recording(), (5.5, 10.5), Path("take.csv"))
    assert [round(part.time[-1] + STEP, 6) for part in parts] == [5.5, 5.0, 10.5]
    assert "cut from 5.5 to 10.49 s" in parts[1].notes[-1]


@pytest.mark.parametrize(
    ("times", "whole", "words"),
    [
        ("auto", recording(changes=tuple(np.arange(0.2, 21, 0.7))), ("rests of 0.5 s", "--cut T,T")),
        ((30.0,), recording(), ("between 0 and 20.99 s", "30")),
    ],
)
def test_what_cannot_be_cut_is_refused(times, whole, words):
    with pytest.raises(InputError) as caught:
        cut(whole, times, Path("take.csv"))
    assert all(word in str(caught.value) for word in words)


@pytest.fixture
def take(tmp_path):
    """The recording as a table with its torque, and a mapping."""
    whole = recording()
    table = np.column_stack(
        [whole.time, 0 * whole.time, 0 * whole.time, whole.positions[:, 0, 0], whole.positions[:, 0, 2], whole.torque]
    )
    np.savetxt(tmp_path / "take.csv", table, delimiter=",", header="t,bx,bz,x,z,tau", comments="", fmt="%.6f")
    mapping = """
        [points]
        base = ["bx", "", "bz"]
        tip = ["x", "", "z"]
        [space]
        unit = "m"
        [time]
        column = "t"
        [input]
        tau = "tau"
    """
    (tmp_path / "map.toml").write_text(mapping, encoding="utf-8")
    return tmp_path


ARM = ["--mass", "0.15", "--diameter", "0.04", "--keq", "1.11", "--map", "map.toml", "--mount", "hanging", "--up", "+z"]


def test_the_command_cuts_a_take(take, monkeypatch):
    monkeypatch.chdir(take)
    command(["take.csv", "-o", "arm", "--input", "take.csv", "--cut", "auto", *ARM], standalone_mode=False)
    dataset = read_dataset(take / "arm")
    assert len(dataset.trials) == len(CHANGES)
    assert all(np.ptp(trial.trajectory.torque) == pytest.approx(0.5) for trial in dataset.trials)


def test_a_start_time_beside_a_cut_is_refused(take, monkeypatch):
    monkeypatch.chdir(take)
    with pytest.raises(InputError, match="no start time with --cut"):
        command(["take.csv", "-o", "arm", "--input", "take.csv", "--cut", "auto", "--t-start", "1", *ARM], standalone_mode=False)
