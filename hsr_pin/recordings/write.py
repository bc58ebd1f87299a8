"""A dataset onto the disk: whole, exact, and never over something else."""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import numpy as np

from hsr_pin.errors import OutputError, RecordingError
from hsr_pin.output import DRAFT, draft_of, left_by_killed
from hsr_pin.recordings.declaration import FILE_NAME, INPUTS, VERSIONS, read_declaration
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.sections import torque_columns
from hsr_pin.trajectory import Channel, Dataset, Section, Trajectory, Trial

#: Ending of the name under which the older dataset stands while a newer one takes its place.
_OLD = "old"


def write_dataset(dataset: Dataset, path: str | Path) -> None:
    """Write a dataset into a folder, so that it reads back equal to the last bit.

    The folder is written beside its place, read back, and moved there in one step; an older dataset there is replaced.
    Notes become comments in ``dataset.toml``. Joint angles and rates have no place in the format and are left out;
    so is the torque where there are pressures or channels, which determine it. Orientations were read as points, and stay so.

    Raises:
        OutputError: the place is a file, or a folder that holds anything but a dataset, or the folder that the dataset was
            read from (raw recordings are never overwritten), or cannot be written; or the dataset is not one that the
            format can hold.
    """
    check_target(path, dataset)
    draft = None
    try:
        target = Path(path).resolve()
        draft = draft_of(target)
        draft.mkdir(parents=True)
        (draft / FILE_NAME).write_text(_declaration(dataset), encoding="utf-8")
        _check_names(dataset, draft)
        for trial in dataset.trials:
            _write_trial(trial.trajectory, draft / f"{trial.name}.csv", dataset.channels)
        read_dataset(draft)
        _move(draft, target)
    except RecordingError as error:
        raise OutputError(
            f"the recording format cannot hold this dataset: {error.subject}",
            expected=error.expected,
            received=error.received,
            hint=error.hint,
            file=path,
        ) from error
    except (OSError, ValueError, RuntimeError) as error:
        raise _cannot_write(path, error) from error
    finally:
        if draft is not None:
            shutil.rmtree(draft, ignore_errors=True)


def _check_names(dataset: Dataset, draft: Path) -> None:
    """Each trial's name must be that of a file in the folder."""
    written = [trial.name for trial in read_declaration(draft / FILE_NAME).trials]
    for trial, name in zip(dataset.trials, written, strict=True):
        if trial.name != name:
            raise RecordingError("trial name", expected="the name of a file", received=repr(trial.name))


def check_target(path: str | Path, dataset: Dataset | None = None) -> None:
    """Refuse a place that a dataset cannot be written to, before anything is computed.

    Args:
        path: the folder to be written.
        dataset: what will be written, if it exists already: it must not go where it came from.

    Raises:
        OutputError: saying what is there.
    """
    try:
        target = Path(path).resolve()
        there = None if not target.exists() else {entry.name for entry in target.iterdir()} if target.is_dir() else "a file"
    except (OSError, ValueError, RuntimeError) as error:
        raise _cannot_write(path, error) from error
    if there is None:
        return
    if dataset is not None and dataset.path is not None and target == dataset.path.resolve():
        raise OutputError("raw recordings are never overwritten", hint="write to another folder", file=path)
    if isinstance(there, str):
        raise OutputError("cannot write the dataset", expected="a folder", received=there, file=path)
    strange = sorted(name for name in there if name != FILE_NAME and not name.endswith(".csv"))
    if there and (FILE_NAME not in there or strange):
        raise OutputError(
            "will not replace the folder",
            expected="a new or empty folder, or a dataset",
            received=f"a folder with {(strange or sorted(there))[0]!r} in it",
            file=path,
        )


def mend(path: str | Path) -> list[str]:
    """Undo what killed writers of a dataset left, drafts and a dataset without its name, and tell it, one sentence each.

    Raises:
        OutputError: it cannot be undone.
    """
    told = []
    try:
        target = Path(path).resolve()
        for old in left_by_killed(target, _OLD):
            if target.exists():
                shutil.rmtree(old)
                told.append(f"{path}: took away {old.name}, an older dataset that a killed command left")
            else:
                old.rename(target)
                told.append(f"{path}: put back from {old.name}, as which a killed command left it")
        for draft in left_by_killed(target, DRAFT):
            shutil.rmtree(draft)
            told.append(f"{path}: took away {draft.name}, which a killed command left half written")
    except (OSError, ValueError, RuntimeError) as error:
        raise _cannot_write(path, error) from error
    return told


def _cannot_write(path: str | Path, error: Exception) -> OutputError:
    reason = getattr(error, "strerror", None) or str(error)  # ValueError: a null byte in the name; RuntimeError: a loop of links
    return OutputError("cannot write the dataset", expected="a place that can be written", received=reason, file=path)


def _move(draft: Path, target: Path) -> None:
    if not target.exists():
        draft.rename(target)
        return
    old = draft.with_suffix(f".{_OLD}")
    target.rename(old)
    try:
        draft.rename(target)
    except BaseException:
        old.rename(target)
        raise
    shutil.rmtree(old)


def _declaration(dataset: Dataset) -> str:
    lines = [f"# {_one_line(note)}" for note in dataset.notes]
    space = dataset.bending == "space"
    lines += [f"format = {VERSIONS[space]}", f"name = {_quoted(dataset.name)}"]
    if dataset.description:
        lines.append(f"description = {_quoted(dataset.description)}")
    lines += ["", "[robot]"]
    lines += [_entry(key, getattr(dataset, key), unit) for key, unit in (("length", "m"), ("mass", "kg"), ("diameter", "m"))]
    lines.append(f"mount = {_quoted(dataset.mount)}")
    if dataset.weighed:
        lines.append("weighed = true")
    if dataset.smoothed is not None:
        lines.append(f"smoothed = {dataset.smoothed}  # samples of the moving average")
    if space:
        lines.append(f"bending = {_quoted(dataset.bending)}")
    if math.isfinite(dataset.torsion):
        lines.append(_entry("torsion", dataset.torsion, "Nm/rad"))
    damped = any(trial.damping is not None for trial in dataset.trials)
    lines += [line for section in dataset.sections for line in _section(section, damped)]
    lines += [line for channel in dataset.channels for line in _channel(channel)]
    if dataset.chain:
        links, placement = dataset.chain
        lines += ["", "[simulation]", f"links = {links}", f"placement = {_quoted(placement)}"]
    for marker in dataset.markers:
        lines += ["", "[[marker]]", f"name = {_quoted(marker.name)}", _entry("arc_length", marker.arc_length, "m")]
        if marker.radius:
            lines += [_entry("radius", marker.radius, "m"), _entry("angle", marker.angle, "rad")]
    for trial in dataset.trials:
        lines += ["", *_trial_declaration(trial)]
    return "\n".join(lines) + "\n"


def _section(section: Section, damped: bool) -> list[str]:
    """Its lines; the damping is left out where no trial has one: what stands in memory is then a placeholder."""
    units = {"length": "m", "mass": "kg", "keq": "Nm/rad"} | ({"damping": "Nm s/rad"} if damped else {})
    return ["", "[[section]]", *(_entry(key, getattr(section, key), unit) for key, unit in units.items())]


def _channel(channel: Channel) -> list[str]:
    table = "[[input]]" if channel.torque else "[[measured]]"
    lines = ["", table, f"columns = [{_quoted(channel.name)}]", f"unit = {_quoted(channel.unit)}"]
    return [*lines, f"torque = [{list(channel.torque)!r}]  # N m per unit"] if channel.torque else lines


def _trial_declaration(trial: Trial) -> list[str]:
    lines = ["[[trial]]", *(f"# {_one_line(note)}" for note in trial.trajectory.notes)]
    lines += [f"file = {_quoted(f'{trial.name}.csv')}", _entry("keq", trial.keq, "Nm/rad")]
    if trial.damping is not None:
        lines.append(_entry("damping", trial.damping, "Nm s/rad, whole arm"))
    if trial.tip_mass:
        lines.append(_entry("tip_mass", trial.tip_mass, "kg"))
    if trial.t_start is not None:
        lines.append(_entry("t_start", trial.t_start, "s"))
    if trial.interpolated is not None:
        says = "straight from sample to sample" if trial.interpolated else "from sample to sample"
        lines.append(f"input = {_quoted(INPUTS[trial.interpolated])}  # {says}")
    return lines


def _entry(key: str, value: float, unit: str) -> str:
    return f"{key} = {float(value)!r}  # {unit}"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # a JSON string is a TOML string, but for DEL


def _one_line(text: str) -> str:
    return "".join(character if character.isprintable() else " " for character in text)


def _write_trial(trajectory: Trajectory, path: Path, channels: tuple[Channel, ...]) -> None:
    columns = [trajectory.time[:, None]]
    header = ["t"]
    if trajectory.pressures is not None:
        header += ["P1", "P2"]
        columns.append(trajectory.pressures)
    elif trajectory.channels is not None:
        header += [channel.name for channel in channels]
        columns.append(trajectory.channels)
    elif trajectory.torque is not None:
        header += ["tau"] if trajectory.torque.ndim == 1 else torque_columns(trajectory.torque.shape[1] // 2)
        columns.append(trajectory.torque.reshape(len(trajectory.time), -1))
    header += [f"{marker.name}_{axis}" for marker in trajectory.markers for axis in "xyz"]
    columns.append(trajectory.positions.reshape(len(trajectory.time), -1))
    with path.open("x", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in np.concatenate(columns, axis=1).tolist():
            writer.writerow("" if value != value else repr(value) for value in row)
