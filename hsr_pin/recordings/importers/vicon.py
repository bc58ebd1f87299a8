"""Reader of CSV exports of Vicon Nexus and Vicon Tracker.

A file consists of sections. Each has its title alone on a line (``Trajectories``, ``Objects``, ...), the frame rate, a line of
names, a line of columns (``Frame,Sub Frame,X,Y,Z,...``; objects have ``RX,RY,RZ,TX,TY,TZ``), a line of units, then frames. Old
files (Workstation, Nexus 1) have ``TRAJECTORIES``, ``100.00,Hz``, and ``Field #,X,Y,Z,...`` without units, which are mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.sheet import Sheet, read_sheet
from hsr_pin.recordings.importers.up import Up
from hsr_pin.trajectory import Array

#: Sections that contain points; for objects and segments, their origins.
POINTS = ("Trajectories", "Markers", "Objects", "Segments")
#: Sections that are skipped.
OTHERS = ("Devices", "Model Outputs", "Joints", "Events", "Analog", "Force Plates")
#: Names of the column of frame numbers, in lower case.
FRAME = ("frame", "field #")
#: Unit of length of a file without a line of units.
DEFAULT_UNIT = "mm"


@dataclass(frozen=True, eq=False)
class _Section:
    frames: Array  # (T,)
    rate: float  # [Hz]
    names: list[str]
    positions: Array  # (T, K, 3) [m]
    units: set[str]


def is_vicon(head: str) -> bool:
    """Return whether the beginning of a text file looks like this format."""
    known = {title.lower() for title in POINTS + OTHERS}
    return any(line.strip(' ,;\t"\r').lower() in known for line in head.split("\n")[:20])


def read_vicon(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from a Vicon file.

    Args:
        path: the file.
        unit: unit of length, in place of that in the file.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    sheet = read_sheet(path)
    every, starts = sheet.titles(POINTS + OTHERS), sheet.titles(POINTS)
    ends = [next((other for other in every if other > row), len(sheet)) for row in starts]
    sections = [_section(sheet, row, end, unit) for row, end in zip(starts, ends, strict=True)]
    if not sections:
        hint = "export the trajectories too"
        raise RecordingError("no section with points", expected=" or ".join(POINTS), hint=hint, file=path, line=1, column=1)
    first = sections[0]
    for row, section in zip(starts[1:], sections[1:], strict=True):
        if section.rate != first.rate or not np.array_equal(section.frames, first.frames):
            raise sheet.fault(row, 0, "section", expected="the same frames as in the previous section", received="other frames")
    if starts[-1] == every[-1]:
        _check_whole(sheet, every, first.frames)
    units = ", ".join(sorted(set().union(*(section.units for section in sections))))
    return capture(
        path,
        "Vicon CSV",
        (first.frames - first.frames[0]) / first.rate if len(first.frames) else first.frames,
        [name for section in sections for name in section.names],
        np.concatenate([section.positions for section in sections], axis=1),
        up=Up("+z", "by the convention of Vicon"),
        unit=units,
        notes=[f"imported from {path.name} (Vicon CSV, {units}, {first.rate:g} Hz)"],
        encoding=sheet.encoding,
    )


def _check_whole(sheet: Sheet, starts: list[int], frames: Array) -> None:
    """Check that the last section does not end before the previous sections.

    Raises:
        RecordingError: the last section ends early, so that the file is truncated.
    """
    for start, end in pairwise(starts):
        if sheet.field(start + 3, 0).lower() == "frame" and sheet.is_number(end - 1, 0) and len(frames):
            last = sheet.value(end - 1, 0)
            if frames[-1] < last:
                expected = f"frames up to {last:g}, as in {sheet.field(start, 0)}"
                hint = "copy or export it again"
                raise sheet.fault(
                    len(sheet) - 1, 0, "the file is truncated", expected=expected, received=f"{frames[-1]:g}", hint=hint
                )


def _section(sheet: Sheet, start: int, end: int, unit: str | None) -> _Section:
    title = sheet.field(start, 0)
    rate_row, name_row, axis_row = start + 1, start + 2, start + 3
    if not sheet.is_number(rate_row, 0) or sheet.value(rate_row, 0) <= 0:
        raise sheet.fault(
            rate_row, 0, f"frame rate of {title}", expected="a rate in Hz", received=repr(sheet.field(rate_row, 0)[:40])
        )
    rate = sheet.value(rate_row, 0)
    if sheet.field(axis_row, 0).lower() not in FRAME:
        raise sheet.fault(
            axis_row,
            0,
            f"columns of {title}",
            expected="a line that begins with Frame",
            received=repr(sheet.field(axis_row, 0)[:40]),
        )
    labels = [label.upper() for label in sheet.row(axis_row)]
    triples = [i for i in range(1, len(labels) - 2) if labels[i : i + 3] in (["X", "Y", "Z"], ["TX", "TY", "TZ"])]
    has_units = axis_row + 1 < end and not sheet.is_number(axis_row + 1, 0)
    names, factors, units = [], [], set()
    for index in triples:
        named = next((i for i in range(index, 0, -1) if sheet.field(name_row, i)), index)
        names.append(sheet.field(name_row, named))
        unit_name = unit or (sheet.field(axis_row + 1, index) if has_units else DEFAULT_UNIT)
        line, column = int(sheet.lines[min(axis_row + 1, len(sheet) - 1)]), index + 1
        factors.append(metres(unit_name, None if unit else sheet.path, line, column))
        units.add(unit_name)
    rows = range(axis_row + 1 + has_units, end)
    values = sheet.numbers(rows, [0, *(index + axis for index in triples for axis in range(3))], ("frame",))
    positions = values[:, 1:].reshape(len(values), len(triples), 3) * np.array(factors).reshape(1, -1, 1)
    return _Section(values[:, 0], rate, names, positions, units)
