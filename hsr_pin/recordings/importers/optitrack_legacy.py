"""Reader of CSV exports of OptiTrack Tracking Tools and early Motive, version 1.1 and older.

The first field of each row names its kind. ``frame``: number, time [s], then each body that was tracked (identifier, position,
quaternion, yaw, pitch, roll), then each marker (position, identifier and, from version 1.1 on, name). ``rigidbody`` or
``trackable``: of the whole file (name, identifier, markers), or of a frame, with the seen position of each of its markers.
Lengths are in metres. The comments at the top of every such file describe the format.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.sheet import Sheet, read_sheet
from hsr_pin.recordings.importers.up import Up

UNIT = "m"
#: Number of fields of a body in a frame: identifier, position, quaternion and angles.
BODY = 11
_BODIES = ("rigidbody", "trackable")
_FIRST = ("comment,", "info,", "righthanded", "lefthanded")


def is_optitrack_legacy(head: str) -> bool:
    """Return whether the beginning of a text file looks like this format."""
    head = head.replace("\t", ",").replace(";", ",").replace('"', "")
    return head.startswith(_FIRST) and any(word in head for word in ("OptiTrack", "NaturalPoint", "handed", "\ninfo,"))


def read_optitrack_legacy(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from a legacy OptiTrack file.

    Args:
        path: the file.
        unit: unit of length; None: metres.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    sheet = read_sheet(path)
    read = _read(sheet)
    sheet.check_count(range(len(read.frames)), read.stated, "info,framecount")
    if not read.places:
        raise RecordingError("no marker in the file", expected="rows that begin with the word frame", file=path)
    positions = np.full((len(read.frames), len(read.places), 3), np.nan)
    for column, found in enumerate(read.places.values()):
        positions[list(found), column] = list(found.values())
    time, note = frame_times(np.array(read.frames, dtype=float), None, np.array(read.stamps))
    notes = [f"imported from {path.name} (OptiTrack CSV {read.version}, {unit or UNIT})", *([note] if note else [])]
    quaternions = {list(read.places).index(name): np.full((len(read.frames), 4), np.nan) for name in read.quaternions}
    for turn, seen in zip(quaternions.values(), read.quaternions.values(), strict=True):
        turn[list(seen)] = list(seen.values())
    if read.left_handed:
        positions[..., 2] *= -1
        quaternions = {place: turn * [1, -1, -1, 1] for place, turn in quaternions.items()}
        notes.append("the axes of the file are left-handed; the sign of z was changed")
    return capture(
        path,
        "OptiTrack CSV",
        time,
        list(read.places),
        positions,
        up=Up("+y", "by the convention of OptiTrack"),
        unit=unit or UNIT,
        factor=metres(unit or UNIT),
        notes=notes,
        encoding=sheet.encoding,
        quaternions=quaternions,
    )


@dataclass
class _Read:
    """Positions of each point by frame, and quaternions of each body by frame, collected while reading."""

    stated: int = 0
    version: str = "1.0"
    left_handed: bool = False
    bodies: dict[int, str] = field(default_factory=dict)
    frames: list[int] = field(default_factory=list)
    stamps: list[float] = field(default_factory=list)
    places: dict[str, dict[int, tuple[float, ...]]] = field(default_factory=dict)
    quaternions: dict[str, dict[int, tuple[float, ...]]] = field(default_factory=dict)


def _read(sheet: Sheet) -> _Read:
    read = _Read()
    for row in range(len(sheet)):
        fields = sheet.row(row)
        sheet.release()
        if sheet.decimal != ".":
            fields = [field.replace(sheet.decimal, ".") for field in fields]
        try:
            if fields[0] == "frame":
                read.frames.append(int(fields[1]))
                read.stamps.append(float(fields[2]))
                _frame(fields, read, len(read.frames) - 1)
            elif fields[0] in _BODIES and fields[1].lstrip("-").isdigit():
                _seen_markers(fields, read.places, len(read.frames) - 1)
            elif fields[0] in _BODIES:
                read.bodies[int(fields[2])] = fields[1]
            elif fields[:2] == ["info", "framecount"]:
                read.stated = int(fields[2])
            elif fields[:2] == ["info", "version"]:
                read.version = fields[2]
            elif fields[0] == "lefthanded":
                read.left_handed = True
        except (ValueError, IndexError):
            hint = "export it again, or remove the row"
            raise sheet.fault(
                row, 0, f"row of {fields[0][:20]!r}", expected="a row as described in the comments of the file", hint=hint
            ) from None
    return read


def _frame(fields: list[str], read: _Read, frame: int) -> None:
    at = 4 + BODY * int(fields[3])
    for start in range(4, at, BODY):
        name = read.bodies.get(int(fields[start]), f"body {fields[start]}")
        read.places.setdefault(name, {})[frame] = _place(fields[start + 1 : start + 4])
        x, y, z, w = (float(field) for field in fields[start + 4 : start + 8])
        read.quaternions.setdefault(name, {})[frame] = w, x, y, z
    count = int(fields[at])
    rest = [field for field in fields[at + 1 :] if field != ""]
    if len(rest) == 5 * count and count and not _is_number(rest[4]):  # with names
        for start in range(0, len(rest), 5):
            read.places.setdefault(rest[start + 4], {})[frame] = _place(rest[start : start + 3])
    elif len(rest) not in (4 * count, 5 * count):
        raise ValueError("markers")


def _seen_markers(fields: list[str], places: dict[str, dict[int, tuple[float, ...]]], frame: int) -> None:
    """Store the seen positions of the markers of one body in a frame, which follow those computed from the body."""
    name, count = fields[3], int(fields[6])
    given = (len(fields) - 8) // count - 5 if count else 3  # coordinates, and from version 1.1 also an identifier
    if given not in (3, 4):
        raise ValueError("markers")
    start = 7 + given * count
    for marker in range(count):
        place = _place(fields[start + 3 * marker : start + 3 * marker + 3])
        if place[0] == place[0]:
            places.setdefault(f"{name}-Marker {marker + 1}", {}).setdefault(frame, place)


def _place(fields: list[str]) -> tuple[float, ...]:
    x, y, z = (float(field) for field in fields)
    return x, y, z


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
