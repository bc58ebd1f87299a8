"""Sections of an arm and the channels that drive them, as declared in a ``dataset.toml`` of version 2 (arms in space)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import cos, inf, isclose, pi, sin
from typing import Any

from hsr_pin.recordings.document import Section as Table
from hsr_pin.trajectory import Channel, Section, Trajectory

#: Largest numbers of sections of an arm and of channels of a recording.
MOST_SECTIONS, MOST_CHANNELS = 50, 200
#: End of the name of a column with the command of a measured input.
COMMAND = "_command"
#: Relative tolerance between the sum over the sections and the number declared for the whole arm.
_ROUNDED = 1e-3


def sections_of(top: Table, robot: Table, length: float, mass: float) -> tuple[Section, ...]:
    """Return the sections of the tables ``[[section]]`` from base to tip; properties they omit are spread evenly over the arm.

    Args:
        top: top-level table of the file.
        robot: table of the whole arm.
        length: length of the whole arm [m].
        mass: mass of the whole arm [kg].

    Raises:
        RecordingError: the sections together contradict the declaration of the whole arm.
    """
    if "section" not in top.values:
        return ()
    tables = top.sections("section")
    if len(tables) > MOST_SECTIONS:
        raise tables[MOST_SECTIONS].fault("sections", expected=f"at most {MOST_SECTIONS}", received=len(tables))
    for table in tables:
        table.only("length", "mass", "keq", "damping")
    parts = [table.number("length", "m") for table in tables]
    _check_whole(robot, "length", "m", length, sum(parts))

    def each(key: str, unit: str, even: Callable[[float], float]) -> list[float]:
        if not any(key in table.values for table in tables):
            return [even(part / length) for part in parts]
        return [table.number(key, unit, zero=key == "damping") for table in tables]

    masses = each("mass", "kg", lambda share: mass * share)
    _check_whole(robot, "mass", "kg", mass, sum(masses))
    whole = {key: _first_declared(key, robot.values, *top.values.get("trial", ())) for key in ("keq", "damping")}
    springs = each("keq", "Nm/rad", lambda share: whole["keq"] / share)
    dampers = each("damping", "Nm s/rad", lambda share: whole["damping"] / share)
    for key, unit, value in (("keq", "Nm/rad", series(springs)), ("damping", "Nm s/rad", averaged(dampers, parts))):
        if key in robot.values:
            _check_whole(robot, key, unit, robot.number(key, unit, zero=True), value)
    return tuple(Section(*numbers) for numbers in zip(parts, masses, springs, dampers, strict=True))


def _first_declared(key: str, *tables: Any) -> float:
    """Return a number of the whole arm from the first table that has it; 1 if none has (sections then differ in length only)."""
    declared = (table.get(key) for table in tables if isinstance(table, dict))
    numbers = (float(value) for value in declared if isinstance(value, int | float) and 0 <= value < inf)
    return next((value for value in numbers if value or key == "damping"), 1.0)


def declared_whole(top: Table, sections: tuple[Section, ...]) -> dict[str, float]:
    """Return stiffness and damping of the whole arm where the sections determine them."""
    declared = {key for table in top.values.get("section", ()) for key in table}
    found = {}
    if "keq" in declared:
        found["keq"] = series([section.keq for section in sections])
    if "damping" in declared:
        found["damping"] = averaged([section.damping for section in sections], [section.length for section in sections])
    return found


def series(springs: list[float]) -> float:
    """Return the stiffness [Nm/rad] of springs in series."""
    return 1 / sum(1 / spring for spring in springs)


def averaged(dampers: list[float], lengths: list[float]) -> float:
    """Return the damping [Nm s/rad] of an arm from the dampers [Nm s/rad] and lengths [m] of its sections."""
    return sum(damper * (length / sum(lengths)) ** 2 for damper, length in zip(dampers, lengths, strict=True))


def _check_whole(robot: Table, key: str, unit: str, declared: float, together: float) -> None:
    if not isclose(declared, together, rel_tol=_ROUNDED):
        expected = f"{together:.6g} {unit}, the value of all sections together"
        raise robot.fault(key, key, expected=expected, received=f"{declared:.6g}", hint="[robot] declares the whole arm")


def torque_columns(sections: int) -> tuple[str, ...]:
    """Return the names of the torque columns: ``tau_x``, ``tau_y``; for several sections ``tau_x_1``, ``tau_y_1``, ..."""
    if sections < 2:
        return "tau_x", "tau_y"
    return tuple(f"tau_{axis}_{section + 1}" for section in range(sections) for axis in "xy")


def input_columns(trajectory: Trajectory, channels: Sequence[Channel]) -> tuple[tuple[str, str], ...]:
    """Return name and unit of each column of the inputs of a trajectory; empty without an input."""
    if trajectory.pressures is not None:
        return ("P1", "bar"), ("P2", "bar")
    if trajectory.channels is not None:
        return tuple((channel.name, channel.unit) for channel in channels)
    if trajectory.torque is None:
        return ()
    names = ("tau",) if trajectory.torque.ndim == 1 else torque_columns(trajectory.torque.shape[1] // 2)
    return tuple((name, "N m") for name in names)


def channels_of(top: Table, sections: int, taken: Collection[str], besides: Collection[str] = ()) -> tuple[Channel, ...]:
    """Return the channels of the tables ``[[input]]`` and ``[[measured]]``, one for each column.

    Args:
        top: top-level table of the file.
        sections: number of sections of the arm, at least one.
        taken: names of columns that are already in use.
        besides: further keys that such a table may have and that are read elsewhere.

    Raises:
        RecordingError: a name is already in use, or a torque refers to a section that does not exist.
    """
    found: list[Channel] = []
    for kind in ("input", "measured"):
        for table in top.sections(kind) if kind in top.values else ():
            table.only("columns", "unit", *(("section", "gain", "angle", "torque") if kind == "input" else ()), *besides)
            names, unit = _names(table, {*taken, *(channel.name for channel in found)}), table.text("unit", "bar")
            torques = _torques(table, len(names), sections) if kind == "input" else [()] * len(names)
            found += [Channel(name, unit, torque) for name, torque in zip(names, torques, strict=True)]
            if len(found) > MOST_CHANNELS:
                raise table.fault("channels", "columns", expected=f"at most {MOST_CHANNELS}", received=len(found))
    if found and not any(channel.torque for channel in found):
        raise top.fault("channels", "measured", expected="also a table [[input]] that declares what drives the arm")
    return tuple(found)


def _names(table: Table, taken: Collection[str]) -> list[str]:
    names: Any = table.values.get("columns")
    good = isinstance(names, list) and names and all(isinstance(name, str) and _is_name(name) for name in names)
    if not good:
        raise table.fault("columns", "columns", expected='column names, such as ["P1", "P2", "P3"]', received=repr(names)[:60])
    for place, name in enumerate(names):
        if name in taken or name in names[:place]:
            raise table.fault(f"column {name!r} is declared twice", "columns", hint="give each column its own name")
    return list(names)


def _is_name(name: str) -> bool:
    return bool(name) and name.isprintable() and name == name.strip() and not set(name) & set(",;\"'")


def _torques(table: Table, count: int, sections: int) -> list[tuple[float, ...]]:
    """Return the torque (2 S,) [N m per unit] of each column."""
    if "torque" in table.values:
        for key in ("section", "gain", "angle"):
            if key in table.values:
                raise table.fault(key, key, expected="either this key or torque, not both")
        rows: Any = table.values["torque"]
        good = isinstance(rows, list) and len(rows) == count and all(_are_numbers(row, 2 * sections) for row in rows)
        if not good:
            expected = f"{2 * sections} numbers [N m per unit] for each of {count} columns: towards x and y per section"
            raise table.fault("torque", "torque", expected=expected, received=repr(rows)[:60])
        return [tuple(map(float, row)) for row in rows]
    section = table.values.get("section", 1 if sections == 1 else None)
    if isinstance(section, bool) or not isinstance(section, int) or not 1 <= section <= sections:
        expected = f"the section that the columns bend, 1 to {sections}, or torque"
        raise table.fault("section", "section", expected=expected, received=repr(section)[:60])
    gain = table.number("gain", "N m per unit", sign=True)
    angle = table.angle("angle") if "angle" in table.values else 0.0
    return around(count, gain, angle, section, sections)


def around(count: int, gain: float, angle: float, section: int = 1, sections: int = 1) -> list[tuple[float, ...]]:
    """Return the torque (2 S,) [N m per unit] of each of several columns spaced evenly around a section.

    Args:
        count: number of columns.
        gain: torque per unit of each column [N m per unit].
        angle: angle of the first column from x towards y of the base [rad].
        section: section that the columns bend, counted from 1.
        sections: number S of sections of the arm.
    """
    torques = []
    for k in range(count):
        row, towards = [0.0] * (2 * sections), angle + 2 * pi * k / count
        row[2 * section - 2 : 2 * section] = gain * cos(towards), gain * sin(towards)
        torques.append(tuple(row))
    return torques


def _are_numbers(row: Any, count: int) -> bool:
    return (
        isinstance(row, list)
        and len(row) == count
        and all(isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e12 for x in row)
    )
