"""Mappings: TOML files that state the meaning of the columns of a table (docs/importing.md)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hsr_pin.recordings.document import Section, read_document
from hsr_pin.recordings.importers.capture import UNITS
from hsr_pin.recordings.importers.up import Up, axis_vector
from hsr_pin.recordings.sections import COMMAND, torque_columns
from hsr_pin.recordings.text import nearest

#: A column by its name or by its number counted from 1, or a formula of several (:mod:`formula`).
Column = str | int
#: Columns of the three coordinates of a point; None is zero everywhere (for a camera that sees a plane).
Coordinates = tuple[Column | None, Column | None, Column | None]

#: Seconds in one of each unit of time.
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
#: Bar in one of each unit of pressure.
PRESSURE_UNITS = {"bar": 1.0, "mbar": 1e-3, "Pa": 1e-5, "kPa": 1e-2, "MPa": 10.0, "psi": 0.0689475729}
#: N m in one of each unit of torque.
TORQUE_UNITS = {"Nm": 1.0, "Nmm": 1e-3}
#: Largest accepted coordinate and unit of length [m].
FARTHEST = 1e6
#: Tables of dataset.toml with which a mapping may describe the arm.
ARM = ("robot", "section", "measured", "marker")
#: Keys that locate the times of commands.
CLOCK = ("time", "time_unit", "time_format", "clock")
#: Accepted relations between the clock of the commands and that of the recording.
CLOCKS = ("capture", "shared")


@dataclass(frozen=True)
class Clock:
    """Columns of times, and how to read them.

    Attributes:
        columns: columns whose sum is the time: one, or two as printed by ROS (``secs``, ``nsecs``).
        factors: seconds per unit of each column.
        form: format of a date and time of day for ``datetime.strptime``; None: the times are numbers.
    """

    columns: tuple[Column, ...]
    factors: tuple[float, ...] = (1.0,)
    form: str | None = None


@dataclass(frozen=True)
class InputMapping:
    """Columns of commands, and how to read them.

    Attributes:
        columns: names and columns of P1 and P2, of the torque or its components, or of channels, and of their commands
            (``P1_command``) if they were measured; in a bag, ``topic:field``.
        factor: bar or N m per unit; 1 for channels.
        time: times of a separate file of commands; None: as in the recording.
        clock: "capture": 0 at the first frame of the recording; "shared": the clock of the recording.
    """

    columns: tuple[tuple[str, Column], ...]
    factor: float
    time: Clock | None = None
    clock: str = "capture"


@dataclass(frozen=True)
class TableMapping:
    """Meaning of the columns of a table, or of the fields of a bag.

    Attributes:
        path: the file of the mapping.
        points: name and three coordinates of each point.
        time: columns of times; None: none.
        frame: column of frame numbers, used with ``rate``.
        rate: frame rate [Hz].
        rest: whether each row is a pose at rest, of which each becomes a trial.
        unit: unit of length.
        factor: metres per unit of length.
        up: axis that is up, if given.
        header: lines of the column names, counted from 1; empty: none; None: the first line.
        sheet: name of the worksheet of a workbook; None: the first one.
        separator: character between fields; None: determined from the file.
        decimal: decimal mark; None: determined from the file.
        input: columns of commands, if any.
        poses: name of each point with an orientation, and columns of its quaternion, real part first.
        x: direction of the x axis of an arm in space, if given.
        origin: position of the base [m] in the laboratory's frame, if given.
        arm: the whole file, which may describe the arm (:mod:`declared`).
    """

    path: Path
    points: tuple[tuple[str, Coordinates], ...] = ()
    time: Clock | None = None
    frame: Column | None = None
    rate: float | None = None
    rest: bool = False
    unit: str = "m"
    factor: float = 1.0
    up: str | None = None
    header: tuple[int, ...] | None = None
    sheet: str | None = None
    separator: str | None = None
    decimal: str | None = None
    input: InputMapping | None = None
    poses: tuple[tuple[str, tuple[Column, ...]], ...] = ()
    x: str | None = None
    origin: tuple[float, ...] | None = None
    arm: Section | None = None

    @property
    def known_up(self) -> Up:
        """Upward axis of the laboratory as given by the mapping."""
        return Up(self.up, f"by {self.path.name}" if self.up else f"{self.path.name} does not state it")


def read_mapping(path: str | Path) -> TableMapping:
    """Read a mapping from a TOML file.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    top = read_document(Path(path))
    top.only("file", "time", "space", "points", "poses", "input", *ARM)
    if not {"points", "input", *ARM} & set(top.values):
        raise top.fault("the mapping is empty", expected="[points], [input], or tables of dataset.toml for the arm")
    facts: dict[str, Any] = {"arm": top}
    if "points" in top.values:
        facts["points"] = _points(top.section("points"))
        if "poses" in top.values:
            facts["poses"] = _poses(top.section("poses"), [name for name, _ in facts["points"]])
        if "time" in top.values:
            facts |= _time(top.section("time"))
    for name, read in (("space", _space), ("file", _file)):
        if name in top.values:
            facts |= read(top.section(name))
    if isinstance(top.values.get("input"), list):
        facts["input"] = _channels([*top.sections("input"), *(top.sections("measured") if "measured" in top.values else ())])
    elif "input" in top.values:
        facts["input"] = _input(top.section("input"))
    return TableMapping(Path(path), **facts)


def _time(section: Section) -> dict[str, Any]:
    section.only("column", "unit", "format", "frame", "rate", "rest")
    if "rest" in section.values:
        if section.values != {"rest": True}:
            expected = "rest = true alone: each row is a pose at rest, without a time"
            raise section.fault("rest", "rest", expected=expected, received=", ".join(section.values))
        return {"rest": True}
    frame = _column(section, "frame") if "frame" in section.values else None
    rate = section.number("rate", "Hz") if "rate" in section.values else None
    if "column" not in section.values and rate is None:
        raise section.fault("no time", expected="a column of times, or a rate [Hz], or rest = true")
    time = _clock(section, "column", "unit", "format") if "column" in section.values else None
    return {"time": time, "frame": frame, "rate": rate}


def _clock(section: Section, column: str, unit: str, form: str) -> Clock:
    """Return the clock of one column and its unit, of a list of each, or of one column and the format of a date."""
    if form in section.values:
        return Clock((_column(section, column),), form=section.text(form))
    columns, units = section.values[column], section.values.get(unit, "s")
    lists = [one if isinstance(one, list) else [one] for one in (columns, units)]
    if len(lists[0]) != len(lists[1]) or not lists[0]:
        expected, received = f"a unit for each of {len(lists[0])} columns", f"{len(lists[1])}"
        raise section.fault(unit, unit, expected=expected, received=received)
    each = [
        Section(section.path, section.key_path, dict(zip((column, unit), pair, strict=True)), section.places)
        for pair in zip(*lists, strict=True)
    ]
    factors = tuple(TIME_UNITS[_one_of(one, unit, TIME_UNITS, "s")] for one in each)
    return Clock(tuple(_column(one, column) for one in each), factors)


def _points(section: Section) -> tuple[tuple[str, Coordinates], ...]:
    found = []
    for name, columns in section.values.items():
        good = isinstance(columns, list) and len(columns) == 3 and all(_is_column(column) or column == "" for column in columns)
        if not good or all(column == "" for column in columns):
            expected = 'three columns for x, y and z: ["x", "y", "z"], [2, 3, 4], or ["x", "", "-y"] in a plane'
            raise section.fault(f"point {name!r}", name, expected=expected, received=repr(columns)[:60])
        x, y, z = (None if column == "" else column for column in columns)
        found.append((name, (x, y, z)))
    if not found:
        raise section.fault("no point", expected='a line for each point, such as tip = ["x", "y", "z"]')
    return tuple(found)


def _poses(section: Section, points: list[str]) -> tuple[tuple[str, tuple[Column, ...]], ...]:
    found = []
    for name, columns in section.values.items():
        if name not in points:
            raise section.fault(f"pose {name!r}", name, expected="the name of a point", hint=nearest(name, points, "points"))
        if not (isinstance(columns, list) and len(columns) == 4 and all(_is_column(column) for column in columns)):
            expected = 'four columns of a quaternion, its real part first: ["qw", "qx", "qy", "qz"]'
            raise section.fault(f"pose {name!r}", name, expected=expected, received=repr(columns)[:60])
        found.append((name, tuple(columns)))
    return tuple(found)


def _space(section: Section) -> dict[str, Any]:
    section.only("unit", "up", "x", "origin")
    facts: dict[str, Any] = {}
    if isinstance(section.values.get("unit"), int | float):  # for example the size of a camera pixel
        facts["factor"] = section.number("unit", "m")
        if facts["factor"] > FARTHEST:
            raise section.fault("unit", "unit", expected=f"at most {FARTHEST:g} m", received=facts["factor"])
        facts["unit"] = f"{facts['factor']:g} m"
    else:
        facts["unit"] = _one_of(section, "unit", UNITS, "m")
        facts["factor"] = UNITS[facts["unit"]]
    if "up" in section.values:
        facts["up"] = section.text("up")
        try:
            axis_vector(facts["up"], "up")
        except ValueError as error:
            raise section.fault("up", "up", expected="+x, -x, +y, -y, +z or -z", received=repr(facts["up"])) from error
    if "x" in section.values:
        facts["x"] = section.text("x")
    if "origin" in section.values:
        origin = section.values["origin"]
        if not (isinstance(origin, list) and len(origin) == 3 and all(_is_near(value) for value in origin)):
            raise section.fault("origin", "origin", expected=f"three numbers [m], up to {FARTHEST:g}", received=repr(origin)[:60])
        facts["origin"] = tuple(map(float, origin))
    return facts


def _is_near(value: object) -> bool:
    return type(value) in (int, float) and abs(value) <= FARTHEST  # type: ignore[arg-type]


def _file(section: Section) -> dict[str, Any]:
    section.only("header", "sheet", "separator", "decimal")
    facts: dict[str, Any] = {}
    if "header" in section.values:
        header = section.values["header"]
        lines = header if isinstance(header, list) else [] if header == 0 and header is not False else [header]
        good = all(type(line) is int and line > 0 for line in lines) and lines == sorted(set(lines)) and header != []
        if not good:
            expected = "the line of the column names, an increasing list of such lines, or 0 for none"
            raise section.fault("header", "header", expected=expected, received=repr(header)[:60])
        facts["header"] = tuple(lines)
    if "sheet" in section.values:
        facts["sheet"] = section.text("sheet")
    for key, known in (("separator", (",", ";", "|", "\t", " ")), ("decimal", (".", ","))):
        if key in section.values:
            value = section.values[key]
            if value not in known:
                raise section.fault(key, key, expected=" or ".join(map(repr, known)), received=repr(value)[:60])
            facts[key] = value
    return facts


def _input(section: Section) -> InputMapping:
    torques = [name for name in section.values if re.fullmatch(r"tau_[xy](_[1-9]\d*)?", name)]
    names = [name for name in ("P1", "P2", "tau") if name in section.values]
    section.only("P1", "P2", "tau", *torques, *(f"{name}{COMMAND}" for name in (*names, *torques)), "unit", *CLOCK)
    in_space = [names for names in (torque_columns(1), torque_columns(len(torques) // 2)) if set(names) == set(torques)]
    if not names and in_space:
        names = list(in_space[0])
    elif torques or names not in (["P1", "P2"], ["tau"]):
        expected = "P1 and P2, or tau; in space tau_x and tau_y, or tau_x_1, tau_y_1, ... for sections"
        hint = "declare several chambers or tendons in tables [[input]] with columns"
        raise section.fault("input", expected=expected, received=" and ".join([*names, *torques]) or "none", hint=hint)
    commands = [f"{name}{COMMAND}" for name in names if f"{name}{COMMAND}" in section.values]
    units, usual = (PRESSURE_UNITS, "bar") if names == ["P1", "P2"] else (TORQUE_UNITS, "Nm")
    return InputMapping(
        columns=tuple((name, _column(section, name)) for name in [*names, *commands]),
        factor=units[_one_of(section, "unit", units, usual)],
        **_command_clock(section),
    )


def _command_clock(section: Section) -> dict[str, Any]:
    return {
        "time": _clock(section, "time", "time_unit", "time_format") if "time" in section.values else None,
        "clock": _one_of(section, "clock", dict.fromkeys(CLOCKS, 0.0), CLOCKS[0]),
    }


def _channels(tables: list[Section]) -> InputMapping:
    """Return the mapping of tables ``[[input]]`` and ``[[measured]]``: their columns or those in ``from``, with one clock."""
    columns: list[tuple[str, Column]] = []
    for table in tables:
        names, sources = table.values.get("columns"), table.values.get("from", table.values.get("columns"))
        if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
            expected = 'column names, such as ["P1", "P2", "P3"]'
            raise table.fault("columns", "columns", expected=expected, received=repr(names)[:60])
        if not isinstance(sources, list) or len(sources) != len(names) or not all(_is_column(column) for column in sources):
            expected = f"{len(names)} columns of the file, each by its name, its number counted from 1, or a formula"
            raise table.fault("from", "from", expected=expected, received=repr(sources)[:60])
        columns += zip(names, sources, strict=True)
        if "command" in table.values:
            commands = table.values["command"]
            if (
                not isinstance(commands, list)
                or len(commands) != len(names)
                or not all(_is_column(column) for column in commands)
            ):
                expected = f"the columns of {len(names)} commands, each by its name, its number counted from 1, or a formula"
                raise table.fault("command", "command", expected=expected, received=repr(commands)[:60])
            columns += zip((f"{name}{COMMAND}" for name in names), commands, strict=True)
    clock_tables = [table for table in tables if set(CLOCK) & set(table.values)]
    if len(clock_tables) > 1:
        raise clock_tables[1].fault("time", expected="the clock of the commands in one table only", received="in two tables")
    return InputMapping(tuple(columns), 1.0, **(_command_clock(clock_tables[0]) if clock_tables else {}))


def _is_column(value: object) -> bool:
    return (isinstance(value, str) and bool(value.strip())) or (isinstance(value, int) and value != 0 and value is not True)


def _column(section: Section, key: str) -> Column:
    value = section.values[key]
    if not _is_column(value) or (isinstance(value, int) and value < 0):
        expected = "a column: its name, its number counted from 1, or a formula"
        raise section.fault(key, key, expected=expected, received=repr(value)[:60])
    return value  # type: ignore[no-any-return]


def _one_of(section: Section, key: str, known: dict[str, float], usual: str) -> str:
    text = section.text(key, usual)
    if text not in known:
        hint = nearest(text, known, "units" if "unit" in key else "ones")
        raise section.fault(key, key, expected=" or ".join(known), received=repr(text[:40]), hint=hint)
    return text
