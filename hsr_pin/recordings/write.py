"""Writing of datasets to disk: complete, exact, and without overwriting other files."""

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
from hsr_pin.recordings.obstacles import obstacle_lines
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.sections import COMMAND, input_columns
from hsr_pin.trajectory import Channel, Dataset, Section, Trajectory, Trial

#: Suffix of the temporary name of an existing dataset while a newer one replaces it.
_OLD = "old"


def write_dataset(dataset: Dataset, path: str | Path) -> None:
    """Write a dataset into a folder so that it reads back bit for bit.

    The folder is written under a temporary name, read back, and renamed in one step; an older dataset there is replaced.
    Notes become comments in ``dataset.toml``. Joint angles and rates are not part of the format and are left out, as is the
    torque where pressures or channels determine it. Orientations were read as points and are written as points.

    Raises:
        OutputError: the path is a file, a folder that contains anything but a dataset, the folder that the dataset was read from
            (raw recordings are never overwritten), or not writable; or the format cannot hold the dataset.
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
    """Check that the name of each trial is the name of its file."""
    written = [trial.name for trial in read_declaration(draft / FILE_NAME).trials]
    for trial, name in zip(dataset.trials, written, strict=True):
        if trial.name != name:
            raise RecordingError("trial name", expected="the name of a file", received=repr(trial.name))


def check_target(path: str | Path, dataset: Dataset | None = None) -> None:
    """Check that a dataset can be written to a folder, before anything is computed.

    Args:
        path: the folder to write.
        dataset: the dataset, if it exists already; it must not be written to the folder it was read from.

    Raises:
        OutputError: the folder cannot be written; the error names what it contains.
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
            received=f"a folder that contains {(strange or sorted(there))[0]!r}",
            file=path,
        )


def recover(path: str | Path) -> list[str]:
    """Remove the temporary folders of interrupted writers and restore a renamed dataset; return a sentence on each change.

    Raises:
        OutputError: a folder cannot be removed or renamed.
    """
    messages = []
    try:
        target = Path(path).resolve()
        for old in left_by_killed(target, _OLD):
            if target.exists():
                shutil.rmtree(old)
                messages.append(f"{path}: removed {old.name}, an older dataset left behind by an interrupted command")
            else:
                old.rename(target)
                messages.append(f"{path}: restored from {old.name}, the name given to it by an interrupted command")
        for draft in left_by_killed(target, DRAFT):
            shutil.rmtree(draft)
            messages.append(f"{path}: removed {draft.name}, an incomplete dataset left behind by an interrupted command")
    except (OSError, ValueError, RuntimeError) as error:
        raise _cannot_write(path, error) from error
    return messages


def _cannot_write(path: str | Path, error: Exception) -> OutputError:
    reason = getattr(error, "strerror", None) or str(error)  # ValueError: a null byte in the name; RuntimeError: a loop of links
    return OutputError("cannot write the dataset", expected="a writable location", received=reason, file=path)


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
    lines += [line for obstacle in dataset.obstacles for line in obstacle_lines(obstacle)]
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
    """Return the lines of a table ``[[section]]``; damping is left out if no trial has one, as it is then a placeholder."""
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
        says = "linearly between samples" if trial.interpolated else "until the next sample"
        lines.append(f"input = {_quoted(INPUTS[trial.interpolated])}  # {says}")
    return lines


def _entry(key: str, value: float, unit: str) -> str:
    return f"{key} = {float(value)!r}  # {unit}"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # a JSON string is a TOML string, except for DEL


def _one_line(text: str) -> str:
    return "".join(character if character.isprintable() else " " for character in text)


def _write_trial(trajectory: Trajectory, path: Path, channels: tuple[Channel, ...]) -> None:
    columns, names = [trajectory.time[:, None]], [name for name, _ in input_columns(trajectory, channels)]
    header = ["t", *names]
    if trajectory.inputs is not None:
        columns.append(trajectory.inputs)
    if trajectory.commanded is not None:
        there = np.flatnonzero(np.isfinite(trajectory.commanded).any(axis=0))
        header += [f"{names[index]}{COMMAND}" for index in there]
        columns.append(trajectory.commanded[:, there])
    header += [f"{marker.name}_{axis}" for marker in trajectory.markers for axis in "xyz"]
    columns.append(trajectory.positions.reshape(len(trajectory.time), -1))
    with path.open("x", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in np.concatenate(columns, axis=1).tolist():
            writer.writerow("" if value != value else repr(value) for value in row)
