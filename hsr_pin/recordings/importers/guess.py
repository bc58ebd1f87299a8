"""Draft of a mapping for a plain table, guessed from the column names and the magnitude of the numbers."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.mapped import names_in
from hsr_pin.recordings.importers.mapping import PRESSURE_UNITS, TIME_UNITS, TORQUE_UNITS
from hsr_pin.recordings.importers.sheet import Sheet, read_sheet
from hsr_pin.recordings.sampling import LONGEST
from hsr_pin.trajectory import Array

#: Number of rows that are inspected, and largest number of lines above the column names.
ROWS, ABOVE = 500, 50
_UNIT = r"[ _]*[\[(]?\b(?P<unit>m|cm|mm|in|s|ms|us|ns|bar|mbar|Pa|kPa|MPa|psi|Nmm?)?[\])]?$"
_TIME = re.compile(r"(?:t|time|times|timestamp|stamp|clock|secs?|seconds)" + _UNIT, re.IGNORECASE)
_PRESSURE = re.compile(r"(?:p|pressure|press|muscle)[ _]*(?:\(:,)?(?P<number>[12])\)?" + _UNIT, re.IGNORECASE)
_TORQUE = re.compile(r"(?:tau|torque|moment)(?:[ _]*(?P<axis>[xy]))?" + _UNIT, re.IGNORECASE)
_AXIS_LAST = re.compile(r"(?P<stem>.*?)[ _.:\-]*(?P<axis>[xyz])" + _UNIT, re.IGNORECASE)
_COLUMN = re.compile(r"(?P<stem>.*)\((?::,)?(?P<axis>[123])(?:,:)?\)")
_AXIS_FIRST = re.compile(r"(?P<axis>[xyz])[ _.:\-]+(?P<stem>.+?)" + _UNIT, re.IGNORECASE)
_AXES = {"1": "x", "2": "y", "3": "z"}  # columns of a matrix in MATLAB
#: Largest plausible number in the first unit, and the unit assumed for larger numbers (5 m, 20 bar, 50 N m).
_LENGTHS = ((5.0, "mm"), (0.0, "m"))
_PRESSURES = ((20_000.0, "Pa"), (2_000.0, "mbar"), (20.0, "kPa"), (0.0, "bar"))
_TORQUES = ((50.0, "Nmm"), (0.0, "Nm"))


def guessed_mapping(path: Path) -> str:
    """Return the text of a mapping (TOML) for a table, with the reason for each guess.

    Raises:
        RecordingError: the table cannot be read, or has no rows of numbers or no columns of coordinates.
    """
    sheet = read_sheet(path)
    header, names = _header(sheet)
    values = _values(sheet, header, len(names))
    columns = {name: values[:, place] for place, name in enumerate(names) if np.isfinite(values[:, place]).any()}
    time = next((name for name in columns if _TIME.fullmatch(name)), None) or next(
        (name for name, column in columns.items() if np.all(np.diff(column) > 0)), None
    )
    inputs = {key: name for name in columns if name != time and (key := _input_key(name))}
    inputs = {
        key: inputs[key]
        for wanted in (("P1", "P2"), ("tau",), ("tau_x", "tau_y"))
        if set(wanted) <= set(inputs)
        for key in wanted
    }
    points = _points([name for name in columns if name != time and name not in inputs.values()])
    if not points:
        hint = "write the mapping by hand: docs/importing.md"
        expected = "columns of points, such as tip_x, tip_y, tip_z"
        raise RecordingError("no points found", expected=expected, received=", ".join(columns)[:100], hint=hint, file=path)
    lines = [f"# guessed by hsr-import from {_quoted(path.name)}: check every line", *_time_lines(time, columns)]
    if header > 0:
        lines += ["", "[file]", f"header = {sheet.lines[header]}"]
    used = [name for triple in points.values() for name in triple if name]
    lines += ["", "[space]", _unit_line(used, columns, _LENGTHS), 'up = "+z"  # not known: give the upward axis (+z, -y, ...)']
    lines += ["", "[points]", *(f"{_quoted(name)} = {_quoted(triple)}" for name, triple in points.items())]
    if inputs:
        sizes = _PRESSURES if "P1" in inputs else _TORQUES
        lines += ["", "[input]", *(f"{key} = {_quoted(name)}" for key, name in inputs.items())]
        lines.append(_unit_line(list(inputs.values()), columns, sizes))
    rest = [name for name in columns if name not in (time, *used, *inputs.values())]
    lines += ["", f"# not used: {', '.join(_quoted(name) for name in rest)}"] if rest else []
    return "\n".join([*lines, "", *_ARM]) + "\n"


_ARM = ("# [robot]", "# mass = 0.15      # kg", "# diameter = 0.04  # m", "# keq = 1.11       # Nm/rad", '# mount = "hanging"')


def _header(sheet: Sheet) -> tuple[int, list[str]]:
    """Return the index of the row of column names and the names: the row above the numbers with most names, or the first.

    Raises:
        RecordingError: the table has no rows of numbers, or no names above them.
    """
    for row in range(min(len(sheet), ABOVE)):
        fields = sheet.row(row)
        if 2 * sum(sheet.is_number(row, field) for field in range(len(fields))) <= len(fields):
            continue
        if row == 0:
            hint = "write the mapping by hand, with [file] header = 0 and column numbers"
            raise sheet.fault(0, 0, "no column names", expected="a line of names above the numbers", hint=hint)
        named = max(range(row), key=lambda above: (sum(map(bool, sheet.row(above))), -above))
        return named, names_in(sheet, named)
    raise sheet.fault(0, 0, "no rows of numbers", expected="numbers under a line of column names")


def _values(sheet: Sheet, header: int, width: int) -> Array:
    """Return the first rows of numbers (R, width); NaN where a field is not a number."""
    rows = range(header + 1, min(len(sheet), header + 1 + ROWS))
    values = np.array([[sheet.value(r, c) if sheet.is_number(r, c) else np.nan for c in range(width)] for r in rows])
    return np.asarray(values[np.isfinite(values).any(axis=1)])


def _input_key(name: str) -> str | None:
    if found := _PRESSURE.fullmatch(name):
        return f"P{found['number']}"
    if found := _TORQUE.fullmatch(name):
        return f"tau_{found['axis'].lower()}" if found["axis"] else "tau"
    return None


def _points(names: Sequence[str]) -> dict[str, list[str]]:
    """Return the x, y and z columns of each point, whose names differ in the axis only; "" for a missing third column."""
    for form in (_AXIS_LAST, _AXIS_FIRST, _COLUMN):
        found: dict[str, dict[str, str]] = {}
        for name in names:
            if match := form.fullmatch(name):
                axis = match["axis"].lower()
                found.setdefault(match["stem"].strip(" _.:-") or "tip", {})[_AXES.get(axis, axis)] = name
        points = {stem: [axes.get(axis, "") for axis in "xyz"] for stem, axes in found.items() if len(axes) > 1}
        if points:
            return {stem: [x, "", y] if not z else [x, y, z] for stem, (x, y, z) in points.items()}
    return {}


def _quoted(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)  # JSON strings and lists of strings are valid TOML


def _stated_unit(name: str, known: Sequence[str]) -> str | None:
    """Return the unit at the end of a name, in brackets or after a space or an underscore; None if there is none."""
    found = re.search(r"[\[( _]([A-Za-z]+)[\])]?$", name)
    return found[1] if found and found[1] in known else None


def _unit_line(names: Sequence[str], columns: dict[str, Array], sizes: Sequence[tuple[float, str]]) -> str:
    known = [*PRESSURE_UNITS, *TORQUE_UNITS, "m", "cm", "mm", "in"]
    stated = next((unit for name in names if (unit := _stated_unit(name, known))), None)
    if stated:
        return f'unit = "{stated}"  # from the column names'
    largest = max(float(np.nanmax(np.abs(columns[name]))) for name in names)
    unit = next((unit for size, unit in sizes if largest > size), sizes[-1][1])
    return f'unit = "{unit}"  # the largest number is {largest:.4g}'


def _time_lines(time: str | None, columns: dict[str, Array]) -> list[str]:
    if time is None:
        return ["", "[time]", "rate = 100.0  # Hz: no column of times was found; give the rate"]
    step = float(np.nanmedian(np.diff(columns[time])))
    unit = _stated_unit(time, list(TIME_UNITS)) or next((unit for unit in TIME_UNITS if step * TIME_UNITS[unit] <= LONGEST), "s")
    return ["", "[time]", f"column = {_quoted(time)}", f'unit = "{unit}"  # rows are {step:.6g} {unit} apart']
