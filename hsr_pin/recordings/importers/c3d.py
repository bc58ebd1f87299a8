"""C3D (https://www.c3d.org), the exchange format of motion capture.

The points are read here and not by a library: the libraries that there are trust what a file says of its own layout, and many say
it wrong (a rate of analog channels that is missing or rounded), so that positions come out of the wrong bytes; a damaged one
takes gigabytes or ends the process. Here the size of the file has the last word.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.files import read_bytes
from hsr_pin.recordings.importers.c3d_layout import layout_of, positions_of
from hsr_pin.recordings.importers.c3d_parameters import BLOCK, Parameters, floats, read_parameters
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.up import Up

#: Second byte of every file.
MAGIC = 0x50
#: Units as they stand in texts of four letters.
CUT_UNITS = {"mete": "meters", "mill": "millimeters"}
#: Largest file [bytes].
LARGEST = 1_000_000_000
#: Points that are no places, as Vicon names them.
NO_PLACES = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
#: Which axis systems have upwards, by a word in their name. POINT:Y_SCREEN does not tell: Qualisys and ART write what is not up.
CONVENTIONS = {
    "vicon": ("+z", "Vicon"),
    "qualisys": ("+z", "Qualisys"),
    "motion analysis": ("+z", "Motion Analysis"),
    "a.r.t": ("+z", "ART"),
    "dtrack": ("+z", "ART"),
    "charnwood": ("+z", "Codamotion"),
    "optitrack": ("+y", "Motive"),
}


def is_c3d(head: bytes) -> bool:
    """Whether the first bytes of a file look like this format."""
    return len(head) >= 2 and head[1] == MAGIC and 1 < head[0] < 128 and b"\0" in head


def read_c3d(path: Path, unit: str | None = None) -> Capture:
    """Read a file.

    Args:
        path: the file.
        unit: of length, in place of what the file says.

    Raises:
        RecordingError: the file is cut short or damaged, holds no points, or gives no rate or unit.
    """
    data = read_bytes(path, LARGEST)
    try:
        parameters = read_parameters(data)
    except (ValueError, IndexError, struct.error) as error:
        hint = "export it anew"
        raise RecordingError("not a C3D file that can be read: damaged", received=error, hint=hint, file=path) from error
    layout = layout_of(data, parameters, path)
    rate = parameters.number("POINT", "RATE") or float(floats(data[20:24], parameters.processor)[0])
    if not (rate > 0 and np.isfinite(rate)):
        raise RecordingError("POINT:RATE", expected="a number of Hz", received=rate, hint="export it anew", file=path)
    said = unit or next(iter(parameters.texts("POINT", "UNITS")), "")
    said = CUT_UNITS.get(said.lower(), said)
    labels = parameters.texts("POINT", "LABELS")[: layout.points]
    labels = [label or f"point {index + 1}" for index, label in enumerate(labels)]
    labels += [f"point {index + 1}" for index in range(len(labels), layout.points)]
    places = _places(parameters, labels)
    positions, all_marked = positions_of(data, layout, parameters.processor)
    positions = positions[:, places] * metres(said, None if unit else path)
    notes = [f"imported from {path.name} (C3D, {said}, {rate:g} Hz)"]
    if all_marked:
        notes.append("every point of the file is marked as not seen (as Simi does): all were taken as seen")
    if len(data) - layout.start - layout.frames * layout.stride >= BLOCK:
        notes.append("the file is longer than its frames; they were read so that points move steadily")
    if len(places) < layout.points:
        notes.append(f"{layout.points - len(places)} angles, forces and other outputs of a model were left out")
    return capture(
        path,
        "C3D" if not _maker(parameters) else f"C3D of {_maker(parameters)}",
        np.arange(len(positions)) / rate,
        [labels[place] for place in places],
        positions,
        up=_up(parameters),
        unit=said,
        notes=notes,
    )


def _places(parameters: Parameters, labels: list[str]) -> list[int]:
    """The points that are places, and no outputs of a model."""
    others = {label for name in NO_PLACES for label in parameters.texts("POINT", name) if label}
    return [index for index, label in enumerate(labels) if label not in others]


def _maker(parameters: Parameters) -> str:
    return " ".join(text for name in ("COMPANY", "SOFTWARE") for text in parameters.texts("MANUFACTURER", name)[:1] if text)[:60]


def _up(parameters: Parameters) -> Up:
    maker = _maker(parameters).lower()
    for word, (axis, system) in CONVENTIONS.items():
        if word in maker:
            return Up(axis, f"as {system} has it")
    screen = next(iter(parameters.texts("POINT", "Y_SCREEN")), "")
    if screen.lower() == "+z":
        return Up("+z", "as POINT:Y_SCREEN has it")
    return Up(None, f"no maker that is known, and POINT:Y_SCREEN is {screen or 'not there'}, which systems fill in as they like")
