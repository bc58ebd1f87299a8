"""Recordings of a robot: a folder with ``robot.toml``, the URDF that it names, and one table of samples for each trial."""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import InputError, quoted
from hsr_pin.recordings.samples import robot_folder
from hsr_pin.robots.robot import Robot
from hsr_pin.trajectory import Array

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # type: ignore[import-not-found,unused-ignore]

#: What the folder is known by.
DOCUMENT = "robot.toml"
#: Its keys, and those of its table of channels.
_KEYS = ("name", "urdf", "joints", "channels", "rotor_inertia", "gravity", "torque_held")
_CHANNELS = ("time", "position", "torque")
#: Fewest samples of a trial.
_FEWEST = 50


@dataclass(frozen=True, eq=False)
class RobotTrial:
    """One recording of a robot.

    Attributes:
        name: of the trial.
        time: (N,) [s], rising.
        position: (N, n) [rad] what the encoders show.
        torque: (N, n) [N m] recorded.
    """

    name: str
    time: Array
    position: Array
    torque: Array


@dataclass(frozen=True, eq=False)
class RobotRecordings:
    """A robot and what was recorded of it.

    Attributes:
        name: of the recordings.
        robot: as declared.
        trials: in the order of their names.
        held: whether a torque stays as it is until the next sample, as drives hold a command; else it goes straight there.
        notes: what a reader should know.
    """

    name: str
    robot: Robot
    trials: tuple[RobotTrial, ...]
    held: bool = True
    notes: tuple[str, ...] = ()


def robot_place(folder: str | Path) -> Path | None:
    """The folder that holds recordings of a robot: this one, or the sample of this name; None where there are none."""
    place = Path(folder)
    return place if (place / DOCUMENT).is_file() else robot_folder(str(folder))


def read_robot(folder: str | Path) -> RobotRecordings:
    """Read recordings of a robot: a folder, or the name of a sample.

    Raises:
        InputError: a file that is missing or not as ``robot.toml`` says, with the place of the fault.
    """
    place = (robot_place(folder) or Path(folder)) / DOCUMENT
    try:
        document = tomllib.loads(place.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(str(place), expected="a TOML document", received=str(error)) from error
    if unknown := [key for key in document if key not in _KEYS]:
        raise InputError(str(place), expected=f"keys among {', '.join(_KEYS)}", received=quoted(unknown[0]))
    joints, channels = _names(document, "joints", place), document.get("channels")
    if not isinstance(channels, Mapping) or set(channels) != set(_CHANNELS):
        raise InputError(f"[channels] of {place}", expected=", ".join(_CHANNELS), received=", ".join(channels or ()) or "nothing")
    columns = [str(channels["time"]), *_names(channels, "position", place), *_names(channels, "torque", place)]
    if len(columns) != 1 + 2 * len(joints):
        expected = f"a position and a torque for each of the {len(joints)} joints"
        raise InputError(f"[channels] of {place}", expected=expected, received=f"{len(columns) - 1} columns")
    more: dict[str, Any] = {}
    if "gravity" in document:
        more["gravity"] = tuple(float(each) for each in document["gravity"])
    urdf = place.parent / str(document.get("urdf", "robot.urdf"))
    robot = Robot.load(urdf, joints, [float(each) for each in document.get("rotor_inertia", ())], **more)
    files = sorted(place.parent.glob("*.csv"))
    if not files:
        raise InputError(str(place.parent), expected="a .csv file for each trial", received="none")
    trials = tuple(_trial(file, columns, len(joints)) for file in files)
    held = document.get("torque_held", True)
    if not isinstance(held, bool):
        raise InputError(f"torque_held of {place}", expected="true or false", received=quoted(held))
    return RobotRecordings(str(document.get("name", place.parent.name)), robot, trials, held, robot.notes)


def _names(table: Mapping[str, Any], key: str, place: Path) -> list[str]:
    names = table.get(key)
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} of {place}", expected='names, as in ["a", "b"]', received=quoted(names))
    return list(names)


def _trial(file: Path, columns: Sequence[str], joints: int) -> RobotTrial:
    """The trial in one table."""
    with file.open(encoding="utf-8", newline="") as stream:
        rows = csv.reader(stream)
        header = [name.strip() for name in next(rows, [])]
        if missing := [name for name in columns if name not in header]:
            raise InputError(f"{file}:1", expected=f"a column {missing[0]}", received=", ".join(header) or "nothing")
        places, values = [header.index(name) for name in columns], []
        for line, row in enumerate(rows, 2):
            try:
                values.append([float(row[place]) for place in places])
            except (ValueError, IndexError) as error:
                raise InputError(f"{file}:{line}", expected=f"{len(header)} numbers", received=",".join(row)) from error
    if len(values) < _FEWEST:
        raise InputError(str(file), expected=f"{_FEWEST} samples or more", received=len(values))
    table = np.array(values)
    if not np.isfinite(table).all() or not (np.diff(table[:, 0]) > 0).all():
        line = int(np.argmax([*(np.diff(table[:, 0]) <= 0), True])) + 3
        raise InputError(f"{file}:{line}", expected="finite numbers, and times that rise", received="others")
    return RobotTrial(file.stem, table[:, 0], table[:, 1 : 1 + joints], table[:, 1 + joints :])
