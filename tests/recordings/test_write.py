"""What is written reads back equal; nothing is half-written, and nothing else is written over."""

import dataclasses
import os

import numpy as np
import pytest

from hsr_pin.errors import OutputError, RecordingError
from hsr_pin.recordings import write
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import check_target, write_dataset
from hsr_pin.trajectory import Marker


def facts(record, *without):
    return {field.name: getattr(record, field.name) for field in dataclasses.fields(record) if field.name not in without}


def same(a, b):
    assert facts(a, "trials", "path", "notes") == facts(b, "trials", "path", "notes")
    for one, other in zip(a.trials, b.trials, strict=True):
        assert facts(one, "trajectory") == facts(other, "trajectory")
        assert one.trajectory.markers == other.trajectory.markers
        for name in ("time", "positions", "torque", "pressures"):
            mine, theirs = getattr(one.trajectory, name), getattr(other.trajectory, name)
            assert (mine is None) == (theirs is None)
            assert mine is None or np.array_equal(mine, theirs, equal_nan=True)


def tree(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_dataset_reads_back_equal_to_the_last_bit(dataset, tmp_path):
    write_dataset(dataset, tmp_path / "new" / "place")
    same(read_dataset(tmp_path / "new" / "place"), dataset)
    measured = dataclasses.replace(dataset.trials[0], interpolated=True)
    write_dataset(dataclasses.replace(dataset, trials=(measured,)), tmp_path / "measured")
    assert read_dataset(tmp_path / "measured").trials[0].interpolated


def test_a_dataset_that_was_read_is_written_as_it_was(folder, tmp_path):
    write_dataset(read_dataset(folder), tmp_path / "copy")
    same(read_dataset(tmp_path / "copy"), read_dataset(folder))


@pytest.mark.parametrize("name", ["tip,left", 'say "so"', "é°", "a#b", "a\\b", "t"])
def test_a_marker_of_any_name_reads_back(dataset, tmp_path, name):
    markers = (*dataset.markers[:2], Marker(name, 0.24))
    trials = tuple(
        dataclasses.replace(trial, trajectory=dataclasses.replace(trial.trajectory, markers=markers)) for trial in dataset.trials
    )
    renamed = dataclasses.replace(dataset, trials=trials, name=name)
    write_dataset(renamed, tmp_path / "named")
    same(read_dataset(tmp_path / "named"), renamed)


def test_notes_are_kept_as_comments(dataset, tmp_path):
    noted = dataclasses.replace(dataset.trials[0].trajectory, notes=("cleaned\nand smoothed",))
    trials = (dataclasses.replace(dataset.trials[0], trajectory=noted), *dataset.trials[1:])
    write_dataset(dataclasses.replace(dataset, trials=trials), tmp_path / "noted")
    text = (tmp_path / "noted" / "dataset.toml").read_text(encoding="utf-8")
    assert "# a note\n" in text
    assert "# cleaned and smoothed\n" in text


def test_an_older_dataset_is_replaced_and_an_empty_folder_filled(dataset, tmp_path):
    (tmp_path / "d").mkdir()
    write_dataset(dataset, tmp_path / "d")
    one = dataclasses.replace(dataset, trials=dataset.trials[:1])
    write_dataset(one, tmp_path / "d")
    assert sorted(tree(tmp_path / "d")) == ["dataset.toml", "run-1.csv"]
    assert [path.name for path in tmp_path.iterdir()] == ["d"]


@pytest.mark.parametrize("there", [["thesis.tex"], ["dataset.toml", "thesis.tex"], ["other.csv"]])
def test_a_folder_with_anything_else_in_it_is_left_alone(dataset, tmp_path, there):
    for name in there:
        (tmp_path / name).write_text("precious", encoding="utf-8")
    before = tree(tmp_path)
    with pytest.raises(OutputError, match="will not replace"):
        write_dataset(dataset, tmp_path)
    with pytest.raises(OutputError, match="will not replace"):
        check_target(tmp_path)
    assert tree(tmp_path) == before


def test_raw_recordings_are_never_written_over(folder):
    before = tree(folder)
    with pytest.raises(OutputError, match="never overwritten"):
        write_dataset(read_dataset(folder), folder)
    assert tree(folder) == before


@pytest.mark.parametrize("place", ["file", "file/below", "a\0b", "x" * 300])
def test_a_place_that_cannot_be_written_is_an_error_of_ours(dataset, tmp_path, place):
    (tmp_path / "file").write_text("precious", encoding="utf-8")
    with pytest.raises(OutputError):
        write_dataset(dataset, tmp_path / place)
    assert tree(tmp_path) == {"file": b"precious"}


def test_a_write_that_breaks_off_leaves_what_was_there(dataset, tmp_path, monkeypatch):
    write_dataset(dataset, tmp_path / "d")
    before = tree(tmp_path)

    def full_disk(trajectory, path, channels):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(write, "_write_trial", full_disk)
    for target in (tmp_path / "d", tmp_path / "e"):
        with pytest.raises(OutputError, match="No space left"):
            write_dataset(dataset, target)
    assert tree(tmp_path) == before
    assert os.listdir(tmp_path) == ["d"]


def test_a_move_that_fails_puts_the_older_dataset_back(dataset, tmp_path, monkeypatch):
    write_dataset(dataset, tmp_path / "d")
    before = tree(tmp_path)
    rename = type(tmp_path).rename

    def fails_once(self, target):
        if self.suffix == ".part":
            raise OSError(5, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(type(tmp_path), "rename", fails_once)
    with pytest.raises(OutputError, match="Input/output"):
        write_dataset(dataset, tmp_path / "d")
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    "change",
    [
        {"mass": -1.0},
        {"length": 240.0},
        {"mount": "sideways"},
        {"name": ""},
        {"description": "two\nlines"},
    ],
)
def test_a_dataset_that_the_format_cannot_hold_is_refused(dataset, tmp_path, change):
    with pytest.raises(OutputError, match="cannot hold"):
        write_dataset(dataclasses.replace(dataset, **change), tmp_path / "d")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["../outside", "", "run-2", "a/b"])
def test_a_trial_whose_name_leads_elsewhere_is_refused(dataset, tmp_path, name):
    trials = (dataclasses.replace(dataset.trials[0], name=name), *dataset.trials[1:])
    with pytest.raises(OutputError):
        write_dataset(dataclasses.replace(dataset, trials=trials), tmp_path / "d")
    assert os.listdir(tmp_path) == []


def test_commands_beside_measured_inputs_read_back_and_leave_the_measured_ones_interpolated(dataset, tmp_path):
    trials = []
    for trial in (trial for trial in dataset.trials if trial.trajectory.has_input):
        commanded = np.round(trial.trajectory.inputs + np.sin(trial.trajectory.time)[:, None], 1)
        trajectory = dataclasses.replace(trial.trajectory, commanded=commanded)
        trials.append(dataclasses.replace(trial, trajectory=trajectory))
    both = dataclasses.replace(dataset, trials=tuple(trials))
    write_dataset(both, tmp_path / "both")
    again = read_dataset(tmp_path / "both")
    same(again, both)
    for one, other in zip(again.trials, both.trials, strict=True):
        assert np.array_equal(one.trajectory.commanded, other.trajectory.commanded)
        assert one.interpolated


def test_a_command_of_an_input_that_is_not_there_is_an_unknown_column(dataset, tmp_path):
    write_dataset(dataset, tmp_path / "one")
    path = tmp_path / "one" / f"{dataset.trials[0].name}.csv"
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([f"{header},P1_command", *(f"{row},1.0" for row in rows)]), encoding="utf-8")
    with pytest.raises(RecordingError, match="unknown column 'P1_command'"):
        read_dataset(tmp_path / "one")
