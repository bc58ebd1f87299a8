"""Reader of CSV exports of OptiTrack Motive with a format version 1.x in the first line.

The first line is pairs of keys and values (``Format Version,1.23,...,Length Units,Meters,...``). Lines of types, names and
identifiers follow, then one of kinds (``Position``, ``Rotation``), one of columns (``Frame,Time (Seconds),X,Y,Z,...``), frames.
"""

from __future__ import annotations

from pathlib import Path

from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.sheet import Sheet, positive, read_sheet
from hsr_pin.recordings.importers.up import Up

#: Kinds of points by priority: a measured marker is preferred to its position computed from a body.
_FIRST = ("Marker", "Rigid Body", "Rigid Body Marker")
#: Unit of length of versions before 1.2, which do not state it.
DEFAULT_UNIT = "Meters"


def is_optitrack(head: str) -> bool:
    """Return whether the beginning of a text file looks like this format."""
    return head.lstrip('" \t').startswith("Format Version")


def read_optitrack(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from an OptiTrack file.

    Args:
        path: the file.
        unit: unit of length, in place of that in the file.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    sheet = read_sheet(path)
    facts = dict(zip(sheet.row(0)[::2], sheet.row(0)[1::2], strict=False))
    version = facts.get("Format Version", "")
    if not version.startswith(("1.", "1,")):
        raise sheet.fault(
            0, 1, "Format Version", expected="1.x", received=repr(version[:40]), hint="export it again with Motive 2 or 3"
        )
    if facts.get("Coordinate Space", "Global") != "Global":
        received, hint = facts["Coordinate Space"][:40], "export it again with global coordinates"
        raise sheet.fault(
            0, sheet.row(0).index("Coordinate Space") + 1, "Coordinate Space", expected="Global", received=received, hint=hint
        )
    unit_name = unit or facts.get("Length Units", DEFAULT_UNIT)
    factor = metres(unit_name, None if unit else path, 1, 1)
    axis_row = next((row for row in range(1, min(12, len(sheet))) if sheet.field(row, 0).lower() == "frame"), None)
    if axis_row is None or axis_row < 3:
        received = repr(sheet.field(3, 0)[:40])
        raise sheet.fault(3, 0, "columns", expected="a line that begins with Frame, under the names", received=received)
    if not sheet.field(axis_row, 1).lower().startswith("time"):
        raise sheet.fault(axis_row, 1, "columns", expected="Time (Seconds)", received=repr(sheet.field(axis_row, 1)[:40]))
    points = _points(sheet, axis_row)
    rows = range(axis_row + 1, len(sheet))
    bodies = {place: index for place, (index, _) in enumerate(points) if _is_turned(sheet, axis_row, index)}
    places = [index + axis for index, _ in points for axis in range(3)]
    quaternions = [index - back for index in bodies.values() for back in (1, 4, 3, 2)]  # X, Y, Z, W precede the position
    values = sheet.numbers(rows, [0, 1, *places, *quaternions], ("frame", "time"))
    sheet.check_count(rows, positive(facts.get("Total Exported Frames", "")), "Total Exported Frames in line 1")
    time, note = frame_times(values[:, 0], positive(facts.get("Export Frame Rate", "")), values[:, 1])
    return capture(
        path,
        "OptiTrack CSV",
        time,
        [name for _, name in points],
        values[:, 2 : 2 + len(places)].reshape(len(rows), len(points), 3),
        up=Up("+y", "by the convention of Motive"),
        unit=unit_name,
        factor=factor,
        notes=[f"imported from {path.name} (OptiTrack CSV {version}, {unit_name})", *([note] if note else [])],
        encoding=sheet.encoding,
        quaternions={place: values[:, 2 + len(places) + 4 * k :][:, :4] for k, place in enumerate(bodies)},
    )


def _is_turned(sheet: Sheet, axis_row: int, index: int) -> bool:
    """Return whether a quaternion precedes a position."""
    fields = range(max(index - 4, 0), index)
    axes = [sheet.field(axis_row, field).upper() for field in fields]
    return axes == ["X", "Y", "Z", "W"] and all(sheet.field(axis_row - 1, field) == "Rotation" for field in fields)


def _points(sheet: Sheet, axis_row: int) -> list[tuple[int, str]]:
    """Return the index of the first column and the name of each point."""
    labelled = {sheet.field(row, 1): row for row in range(1, axis_row)}
    type_row, name_row = labelled.get("Type", 1), labelled.get("Name", 2)
    found = []
    for index in range(2, len(sheet.row(axis_row)) - 2):
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
