"""OptiTrack Motive, CSV export, header versions 1.20 to 1.29 (Motive 2 and 3).

The first line is pairs of keys and values (``Format Version,1.23,...,Length Units,Meters,...``). Lines of types, names and
identifiers follow, then one of kinds (``Position``, ``Rotation``), one of columns (``Frame,Time (Seconds),X,Y,Z,...``), frames.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.sheet import Sheet, read_sheet

#: A marker that was seen goes before the place that a solved body gives to it.
_FIRST = ("Marker", "Rigid Body", "Rigid Body Marker")


def is_optitrack(head: str) -> bool:
    """Whether the beginning of a text file looks like this format."""
    return head.lstrip('" \t').startswith("Format Version")


def read_optitrack(path: Path, unit: str | None = None) -> Capture:
    """Read a file.

    Args:
        path: the file.
        unit: of length, in place of what the file says.

    Raises:
        RecordingError: with file, line and column of the first fault.
    """
    sheet = read_sheet(path)
    facts = dict(zip(sheet.rows[0][::2], sheet.rows[0][1::2], strict=False))
    version = facts.get("Format Version", "")
    if not version.startswith("1.2"):
        raise sheet.fault(
            0, 1, "Format Version", expected="1.2x", received=repr(version[:40]), hint="export it anew with Motive 2 or 3"
        )
    if facts.get("Coordinate Space", "Global") != "Global":
        raise sheet.fault(0, 0, "Coordinate Space", expected="Global", received=facts["Coordinate Space"][:40])
    said = unit or facts.get("Length Units", "")
    factor = metres(said, None if unit else path, 1, 1)
    axis_row = next((row for row in range(1, len(sheet.rows)) if sheet.field(row, 0).lower() == "frame"), None)
    if axis_row is None or axis_row < 3:
        raise sheet.fault(
            len(sheet.rows) - 1, 0, "columns", expected="a line that begins with Frame, under the names", received="none"
        )
    points = _points(sheet, axis_row)
    rows = range(axis_row + 1, len(sheet.rows))
    if not sheet.field(axis_row, 1).lower().startswith("time"):
        raise sheet.fault(axis_row, 1, "columns", expected="Time (Seconds)", received=repr(sheet.field(axis_row, 1)[:40]))
    time = sheet.numbers(rows, [1])[:, 0]
    if np.isnan(time).any():
        raise sheet.fault(rows[int(np.argmax(np.isnan(time)))], 1, "time", expected="a number", received="no value")
    values = sheet.numbers(rows, [index + axis for index, _ in points for axis in range(3)])
    return capture(
        path,
        "OptiTrack CSV",
        time,
        [name for _, name in points],
        values.reshape(len(time), len(points), 3) * factor,
        up="+y",
        notes=[f"imported from {path.name} (OptiTrack CSV {version}, {said})"],
    )


def _points(sheet: Sheet, axis_row: int) -> list[tuple[int, str]]:
    """The first column of each point, and its name."""
    labelled = {sheet.field(row, 1): row for row in range(1, axis_row)}
    type_row, name_row = labelled.get("Type", 1), labelled.get("Name", 2)
    found = []
    for index in range(2, len(sheet.rows[axis_row]) - 2):
        axes = [sheet.field(axis_row, index + axis).upper() for axis in range(3)]
        if axes == ["X", "Y", "Z"] and sheet.field(axis_row - 1, index) == "Position":
            found.append((index, sheet.field(type_row, index), sheet.field(name_row, index)))
    found.sort(key=lambda point: _FIRST.index(point[1]) if point[1] in _FIRST else len(_FIRST))
    taken: set[str] = set()
    points = []
    for index, kind, name in found:
        points.append((index, f"{name} ({kind})" if name in taken else name))
        taken.add(name)
    return points
