"""Reader for recordings of a robot: a folder with ``robot.toml``, its URDF, and one table or bag for each trial."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import InputError, quoted
from hsr_pin.recordings.grid import hold
from hsr_pin.recordings.importers.mapping import TIME_UNITS, TORQUE_UNITS
from hsr_pin.recordings.importers.rosbag_fields import read_bag_numbers
from hsr_pin.recordings.samples import robot_folder
from hsr_pin.robots.robot import Robot
from hsr_pin.robots.servo import Servo, estimate_servo
from hsr_pin.trajectory import Array

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # type: ignore[import-not-found,unused-ignore]

#: Name of the document that describes the recordings in a folder.
DOCUMENT = "robot.toml"
#: Keys of the document, and of its table [servo].
_KEYS = (
    "name",
    "urdf",
    "joints",
    "channels",
    "units",
    "servo",
    "rotor_inertia",
    "encoders",
    "accuracy",
    "gravity",
    "torque_held",
    "torque_constant",
)
_SERVO_KEYS = ("stiffness", "damping", "limit", "guessed")
#: Names of the possible command channels.
_COMMANDS = ("torque", "target")
#: Allowed units of the channels, with their factors to s, rad and N m.
_UNITS = {"time": TIME_UNITS, "position": {"rad": 1.0, "deg": float(np.pi / 180)}, "torque": TORQUE_UNITS}
#: File patterns of trials: tables and bags.
_TABLE, _BAGS = "*.csv", ("*.mcap", "*.bag")
#: Smallest number of samples of a trial.
_MIN_SAMPLES = 50


@dataclass(frozen=True, eq=False)
class RobotTrial:
    """One recording of a robot.

    Attributes:
        name: name of the trial.
        time: (N,) increasing times [s].
        position: (N, n) encoder angles [rad].
        command: (N, n) recorded torque [N m], or target angle of a servo [rad], NaN while the servo is off.
    """

    name: str
    time: Array
    position: Array
    command: Array


@dataclass(frozen=True, eq=False)
class RobotRecordings:
    """A robot and its recordings.

    Attributes:
        name: name of the recordings.
        robot: the robot as declared.
        trials: trials, sorted by name.
        held: whether a command is held until the next sample, as drives do; otherwise it is interpolated linearly.
        notes: notes for the reader of a report.
    """

    name: str
    robot: Robot
    trials: tuple[RobotTrial, ...]
    held: bool = True
    notes: tuple[str, ...] = ()


def robot_place(folder: str | Path) -> Path | None:
    """Return the folder with recordings of a robot: the given folder, or the sample of this name; None if there is none."""
    place = Path(folder)
    return place if (place / DOCUMENT).is_file() else robot_folder(str(folder))


def read_robot(folder: str | Path) -> RobotRecordings:
    """Read recordings of a robot from a folder or from the sample of a name.

    Raises:
        InputError: a file is missing or does not match ``robot.toml``; the message gives the place of the fault.
        RecordingError: a bag cannot be read, or lacks a channel.
    """
    place = (robot_place(folder) or Path(folder)) / DOCUMENT
    try:
        document = tomllib.loads(place.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(str(place), expected="a TOML document", received=str(error)) from error
    _check_keys(document, _KEYS, str(place))
    joints = _names(document, "joints", place)
    more: dict[str, Any] = {"gravity": tuple(_numbers(document, "gravity", place, 3))} if "gravity" in document else {}
    more["encoders"] = document.get("encoders", "")
    if "accuracy" in document:
        (more["accuracy"],) = _numbers({"accuracy": [document["accuracy"]]}, "accuracy", place, 1)
    rotors = _numbers(document, "rotor_inertia", place, len(joints)) if "rotor_inertia" in document else []
    robot = Robot.load(place.parent / str(document.get("urdf", "robot.urdf")), joints, rotors, **more)
    columns = _Columns.of(document, len(joints), place)
    files = sorted(file for ending in (_TABLE, *_BAGS) for file in place.parent.glob(ending))
    if not files:
        raise InputError(str(place.parent), expected="a .csv, .mcap or .bag file for each trial", received="none")
    held = document.get("torque_held", True)
    if not isinstance(held, bool):
        raise InputError(f"torque_held of {place}", expected="true or false", received=quoted(held))
    trials = tuple((_table if file.suffix == ".csv" else _bag)(file, columns, held) for file in files)
    if columns.target:
        robot = replace(robot, servo=_servo(document, robot, trials, place))
    elif "servo" in document:
        raise InputError(f"[channels] of {place}", expected="target, because there is a [servo]", received="torque")
    return RobotRecordings(str(document.get("name", place.parent.name)), robot, trials, held, robot.notes)


@dataclass(frozen=True)
class _Columns:
    """Columns of a table, or fields of a bag, that contain the channels.

    Attributes:
        time: name of the time column; None: the messages of a bag have their own times.
        names: columns of the positions of all joints, then of the commands.
        factors: (1 + 2 n,) factors of time, positions and commands, to s, rad and N m.
        target: whether the commands are target angles.
    """

    time: str | None
    names: tuple[str, ...]
    factors: tuple[float, ...]
    target: bool

    @classmethod
    def of(cls, document: Mapping[str, Any], joints: int, place: Path) -> _Columns:
        channels, units = document.get("channels"), document.get("units", {})
        where = f"[channels] of {place}"
        given = [each for each in _COMMANDS if isinstance(channels, Mapping) and each in channels]
        if not isinstance(channels, Mapping) or len(given) != 1 or "position" not in channels:
            expected = "time, position, and either torque or target"
            raise InputError(where, expected=expected, received=", ".join(channels or ()) or "nothing")
        (command,) = given
        _check_keys(channels, ("time", "position", command), where)
        names = [*_names(channels, "position", place), *_names(channels, command, place)]
        if len(names) != 2 * joints:
            expected = f"a position and a {command} for each of the {joints} joints"
            raise InputError(where, expected=expected, received=f"{len(names)} columns")
        _check_keys(units, _UNITS, f"[units] of {place}")
        factor = {}
        for name, known in _UNITS.items():
            unit = units.get(name, next(iter(known)))
            if not isinstance(unit, str) or unit not in known:
                raise InputError(f"[units] {name} of {place}", expected=f"one of {', '.join(known)}", received=quoted(unit))
            factor[name] = known[unit]
        constant, target = [1.0] * joints, command == "target"
        if "torque_constant" in document:
            constant = _numbers(document, "torque_constant", place, joints)
            if target:
                raise InputError(
                    f"torque_constant of {place}", expected="[channels] torque, which it converts", received="target"
                )
        commands = [factor["position"]] * joints if target else [factor["torque"] * each for each in constant]
        factors = (factor["time"], *[factor["position"]] * joints, *commands)
        return cls(str(channels["time"]) if "time" in channels else None, tuple(names), factors, target)


def _check_keys(table: Any, keys: Iterable[str], where: str) -> None:
    unknown = [key for key in table if key not in keys] if isinstance(table, Mapping) else [table]
    if unknown:
        raise InputError(where, expected=f"keys among {', '.join(keys)}", received=quoted(unknown[0]))


def _names(table: Mapping[str, Any], key: str, place: Path) -> list[str]:
    names = table.get(key)
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} of {place}", expected='names, such as ["a", "b"]', received=quoted(names))
    return list(names)


def _numbers(table: Mapping[str, Any], key: str, place: Path, count: int) -> list[float]:
    numbers = table[key]
    if not isinstance(numbers, list) or len(numbers) != count or not all(type(each) in (int, float) for each in numbers):
        raise InputError(f"{key} of {place}", expected=f"{count} numbers, such as [1.0, 2.0]", received=quoted(numbers))
    return [float(each) for each in numbers]


def _servo(document: Mapping[str, Any], robot: Robot, trials: Sequence[RobotTrial], place: Path) -> Servo:
    """Return the position servos; numbers that the document does not contain are estimated from the trials."""
    given, where = document.get("servo", {}), f"[servo] of {place}"
    _check_keys(given, _SERVO_KEYS, where)
    numbers = {key: _numbers(given, key, place, len(robot.joints)) for key in ("stiffness", "damping", "limit") if key in given}
    guessed = given.get("guessed", "stiffness" not in given)
    if not isinstance(guessed, bool):
        raise InputError(f"guessed in {where}", expected="true or false", received=quoted(guessed))
    if "stiffness" not in given:
        numbers = (
            estimate_servo(robot.model, robot.order, [(each.time, each.position, each.command) for each in trials]) | numbers
        )
    return Servo.of(len(robot.joints), **numbers, guessed=guessed)


def _table(file: Path, columns: _Columns, _held: bool) -> RobotTrial:
    """Return the trial in one CSV table."""
    if columns.time is None:
        raise InputError(str(file), expected="time among the [channels], because the trial is a table", received="none")
    wanted = [columns.time, *columns.names]
    empty = [columns.target and k > len(columns.names) // 2 for k in range(len(wanted))]
    with file.open(encoding="utf-8", newline="") as stream:
        rows = csv.reader(stream)
        header = [name.strip() for name in next(rows, [])]
        if missing := [name for name in wanted if name not in header]:
            raise InputError(f"{file}:1", expected=f"a column {missing[0]}", received=", ".join(header) or "nothing")
        places, values = [header.index(name) for name in wanted], []
        for line, row in enumerate(rows, 2):
            try:
                cells = [row[place].strip() for place in places]
                values.append([np.nan if may and not cell else float(cell) for cell, may in zip(cells, empty, strict=True)])
            except (ValueError, IndexError) as error:
                raise InputError(f"{file}:{line}", expected=f"{len(header)} numbers", received=",".join(row)) from error
    table = np.reshape(values, (-1, len(wanted))) * columns.factors
    return _checked_trial(
        file, table, len(columns.names) // 2, columns.target, [f"{file}:{line}" for line in range(2, len(values) + 2)]
    )


def _bag(file: Path, columns: _Columns, held: bool) -> RobotTrial:
    """Return the trial in one bag, sampled at the times of the first joint's messages."""
    tracks = read_bag_numbers(file, columns.names)
    joints = len(columns.names) // 2
    time = tracks[0][0]
    time = time[(time >= max(track[0][0] for track in tracks)) & (time <= min(track[0][-1] for track in tracks))]
    found = [time - time[0]] if len(time) else [time]
    for k, (at, values) in enumerate(tracks):
        found.append(hold(at, values[:, None], time)[:, 0] if held and k >= joints else np.interp(time, at, values))
    table = np.column_stack(found) * (1.0, *columns.factors[1:])
    return _checked_trial(file, table, joints, columns.target, [f"{file}, message {n}" for n in range(1, len(table) + 1)])


def _checked_trial(file: Path, table: Array, joints: int, target: bool, places: Sequence[str]) -> RobotTrial:
    """Return the trial in a table (N, 1 + 2 n) of times, positions and commands, after checking its values."""
    if len(table) < _MIN_SAMPLES:
        raise InputError(str(file), expected=f"{_MIN_SAMPLES} samples or more", received=len(table))
    finite = np.isfinite(table[:, : 1 + joints] if target else table).all(axis=1) & ~np.isinf(table).any(axis=1)
    if not finite.all():
        raise InputError(places[int(np.argmin(finite))], expected="finite numbers", received="NaN, infinity or an empty cell")
    if not (rises := np.diff(table[:, 0]) > 0).all():
        raise InputError(places[int(np.argmin(rises)) + 1], expected="increasing times", received="a time that does not increase")
    return RobotTrial(file.stem, table[:, 0], table[:, 1 : 1 + joints], table[:, 1 + joints :])
