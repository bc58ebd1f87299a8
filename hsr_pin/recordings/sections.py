"""What a ``dataset.toml`` declares of sections, and of the channels that drive them: version 2 of the format, arms in space."""

from __future__ import annotations

from collections.abc import Callable, Collection
from math import cos, inf, isclose, pi, sin
from typing import Any

from hsr_pin.recordings.document import Section as Table
from hsr_pin.trajectory import Channel, Section

#: No arm has more sections, and no recording more channels.
MOST_SECTIONS, MOST_CHANNELS = 50, 200
#: By how much of itself what sections are together may differ from what is declared of the whole arm.
_ROUNDED = 1e-3


def sections_of(top: Table, robot: Table, length: float, mass: float) -> tuple[Section, ...]:
    """The tables ``[[section]]``, from the base on; what none of them says is spread evenly over the arm.

    Args:
        top: of the file.
        robot: its table of the whole arm.
        length: of the whole arm [m].
        mass: of the whole arm [kg].

    Raises:
        RecordingError: they are not what is declared of the whole arm.
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
    whole = {key: _first_said(key, robot.values, *top.values.get("trial", ())) for key in ("keq", "damping")}
    springs = each("keq", "Nm/rad", lambda share: whole["keq"] / share)
    dampers = each("damping", "Nm s/rad", lambda share: whole["damping"] / share)
    for key, unit, value in (("keq", "Nm/rad", series(springs)), ("damping", "Nm s/rad", averaged(dampers, parts))):
        if key in robot.values:
            _check_whole(robot, key, unit, robot.number(key, unit, zero=True), value)
    return tuple(Section(*numbers) for numbers in zip(parts, masses, springs, dampers, strict=True))


def _first_said(key: str, *tables: Any) -> float:
    """A number of the whole arm as the first table has it; 1 where nobody says it: sections then differ by length alone."""
    said = (table.get(key) for table in tables if isinstance(table, dict))
    numbers = (float(value) for value in said if isinstance(value, int | float) and 0 <= value < inf)
    return next((value for value in numbers if value or key == "damping"), 1.0)


def declared_whole(top: Table, sections: tuple[Section, ...]) -> dict[str, float]:
    """Stiffness and damping of the whole arm, where the sections' own say them."""
    said = {key for table in top.values.get("section", ()) for key in table}
    found = {}
    if "keq" in said:
        found["keq"] = series([section.keq for section in sections])
    if "damping" in said:
        found["damping"] = averaged([section.damping for section in sections], [section.length for section in sections])
    return found


def series(springs: list[float]) -> float:
    """Stiffness [Nm/rad] of springs in series."""
    return 1 / sum(1 / spring for spring in springs)


def averaged(dampers: list[float], lengths: list[float]) -> float:
    """Damping [Nm s/rad] of an arm whose sections have these, and these lengths [m]."""
    return sum(damper * (length / sum(lengths)) ** 2 for damper, length in zip(dampers, lengths, strict=True))


def _check_whole(robot: Table, key: str, unit: str, declared: float, together: float) -> None:
    if not isclose(declared, together, rel_tol=_ROUNDED):
        expected = f"{together:.6g} {unit}, as all sections together"
        raise robot.fault(key, key, expected=expected, received=f"{declared:.6g}", hint="[robot] declares the whole arm")


def torque_columns(sections: int) -> tuple[str, ...]:
    """Columns of the torque of so many sections: ``tau_x``, ``tau_y``; of more than one ``tau_x_1``, ``tau_y_1``, ..."""
    if sections < 2:
        return "tau_x", "tau_y"
    return tuple(f"tau_{axis}_{section + 1}" for section in range(sections) for axis in "xy")


def channels_of(top: Table, sections: int, taken: Collection[str], besides: Collection[str] = ()) -> tuple[Channel, ...]:
    """The tables ``[[input]]`` and ``[[measured]]``, column by column.

    Args:
        top: of the file.
        sections: how many the arm has, at least one.
        taken: names of columns that they must not have.
        besides: keys that such a table may have too, and that are read elsewhere.

    Raises:
        RecordingError: a name that is taken, or a torque of other sections than there are.
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
        raise top.fault("channels", "measured", expected="a table [[input]] beside them, for what drives the arm")
    return tuple(found)


def _names(table: Table, taken: Collection[str]) -> list[str]:
    names: Any = table.values.get("columns")
    good = isinstance(names, list) and names and all(isinstance(name, str) and _is_name(name) for name in names)
    if not good:
        raise table.fault("columns", "columns", expected='names of columns, as ["P1", "P2", "P3"]', received=repr(names)[:60])
    for place, name in enumerate(names):
        if name in taken or name in names[:place]:
            raise table.fault(f"column {name!r} is there already", "columns", hint="give each column its own name")
    return list(names)


def _is_name(name: str) -> bool:
    return bool(name) and name.isprintable() and name == name.strip() and not set(name) & set(",;\"'")


def _torques(table: Table, count: int, sections: int) -> list[tuple[float, ...]]:
    """For each of the columns (2 S,) [N m per unit]."""
    if "torque" in table.values:
        for key in ("section", "gain", "angle"):
            if key in table.values:
                raise table.fault(key, key, expected="no torque beside it, or torque alone")
        rows: Any = table.values["torque"]
        good = isinstance(rows, list) and len(rows) == count and all(_are_numbers(row, 2 * sections) for row in rows)
        if not good:
            expected = f"for each of {count} columns {2 * sections} numbers [N m per unit]: towards x and y for each section"
            raise table.fault("torque", "torque", expected=expected, received=repr(rows)[:60])
        return [tuple(map(float, row)) for row in rows]
    section = table.values.get("section", 1 if sections == 1 else None)
    if isinstance(section, bool) or not isinstance(section, int) or not 1 <= section <= sections:
        expected = f"the section that they bend, 1 to {sections}, or torque"
        raise table.fault("section", "section", expected=expected, received=repr(section)[:60])
    gain = table.number("gain", "N m per unit", sign=True)
    angle = table.angle("angle") if "angle" in table.values else 0.0
    return around(count, gain, angle, section, sections)


def around(count: int, gain: float, angle: float, section: int = 1, sections: int = 1) -> list[tuple[float, ...]]:
    """What columns that lie evenly around a section give: for each (2 S,) [N m per unit].

    Args:
        count: of columns.
        gain: [N m per unit] of each.
        angle: [rad] of the first, from x towards y of the base.
        section: that they bend, from 1.
        sections: S, how many the arm has.
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
