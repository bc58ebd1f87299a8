"""Reader of TRC files (Track Row Column) of Motion Analysis, OpenSim, Pose2Sim and others.

``PathFileType``, a line of keys (``DataRate``, ``NumFrames``, ``Units``, ...) and one of their values, a line of names
(``Frame#``, ``Time``, then one for every three columns), one of axes (``X1 Y1 Z1 ...``), frames. Fields are separated by tabs.
"""

from __future__ import annotations

from pathlib import Path

from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.sheet import positive, read_sheet
from hsr_pin.recordings.importers.up import Up


def is_trc(head: str) -> bool:
    """Return whether the beginning of a text file looks like this format."""
    return head.lstrip('" \t').startswith("PathFileType")


def read_trc(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from a TRC file.

    Args:
        path: the file.
        unit: unit of length, in place of that in the file.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    sheet = read_sheet(path)
    facts = dict(zip(filter(None, sheet.row(1)), filter(None, sheet.row(2)), strict=False))
    unit_name = unit or facts.get("Units", "")
    place = sheet.row(1).index("Units") if "Units" in facts else 0
    factor = metres(unit_name, None if unit else path, int(sheet.lines[min(2, len(sheet) - 1)]), place + 1)
    names_row = next((row for row in range(3, min(8, len(sheet))) if sheet.field(row, 0).lower().startswith("frame")), None)
    if names_row is None:
        received, hint = repr(sheet.field(3, 0)[:40]), "the file may be truncated; export it again"
        raise sheet.fault(3, 0, "columns", expected="a line that begins with Frame#", received=received, hint=hint)
    names = [name for name in sheet.row(names_row)[2:] if name]
    first = names_row + 1
    while first < len(sheet) and not sheet.is_number(first, 0):
        first += 1
    rows = range(first, len(sheet))
    if not names or not rows:
        received = f"{len(names)} markers, {len(rows)} frames"
        raise sheet.fault(
            names_row,
            0,
            "no marker in the file",
            expected="names of markers, and frames",
            received=received,
            hint="label the markers before the export",
        )
    values = sheet.numbers(rows, range(2 + 3 * len(names)), ("frame", "time"))
    sheet.check_count(rows, positive(facts.get("NumFrames", "")), f"NumFrames in line {sheet.lines[2]}")
    time, note = frame_times(values[:, 0], positive(facts.get("DataRate", "")), values[:, 1])
    return capture(
        path,
        "TRC",
        time,
        names,
        values[:, 2:].reshape(len(rows), len(names), 3),
        up=Up(None, "TRC files do not state it (z in Cortex, y in OpenSim)"),
        unit=unit_name,
        factor=factor,
        notes=[f"imported from {path.name} (TRC, {unit_name})", *([note] if note else [])],
        encoding=sheet.encoding,
    )
