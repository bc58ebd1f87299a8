"""Reader of C3D files (https://www.c3d.org), the exchange format of motion capture.

The points are read here and not by a library. Existing libraries trust the layout stated in the file, which is often wrong
(for example a missing or rounded rate of the analog channels), so that positions are read from the wrong bytes. With a damaged
file they allocate gigabytes or end the process. This reader checks the layout against the size of the file.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.files import read_bytes
from hsr_pin.recordings.importers.c3d_parameters import BLOCK, Parameters, floats, read_parameters
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.up import Up

#: Second byte of every C3D file.
MAGIC = 0x50
#: Units abbreviated to four letters.
CUT_UNITS = {"mete": "meters", "mill": "millimeters"}
#: Largest file [bytes].
LARGEST = 1_000_000_000
#: Relative tolerance between two scales.
SAME_SCALE = 1e-3
#: Last frame in the header of a recording that is too long for the header.
TOO_LONG = 0xFFFF
#: Outputs of a Vicon model that are not positions.
NO_PLACES = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
#: Upward axis of known systems, by a word in their name. POINT:Y_SCREEN is not reliable: Qualisys and ART write another axis.
CONVENTIONS = {
    "vicon": ("+z", "Vicon"),
    "qualisys": ("+z", "Qualisys"),
    "motion analysis": ("+z", "Motion Analysis"),
    "a.r.t": ("+z", "ART"),
    "dtrack": ("+z", "ART"),
    "charnwood": ("+z", "Codamotion"),
    "optitrack": ("+y", "Motive"),
}


@dataclass(frozen=True)
class Layout:
    """Layout of the point data in a C3D file.

    Attributes:
        start: position of the first frame [bytes].
        points: number of points in a frame.
        analog: number of analog samples after the points of a frame.
        frames: number of frames.
        real: whether numbers are 32-bit floats; otherwise they are 16-bit integers to be scaled.
        scale: units of length for an integer of 1.
    """

    start: int
    points: int
    analog: int
    frames: int
    real: bool
    scale: float

    @property
    def stride(self) -> int:
        """Size of a frame [bytes]."""
        return (4 * self.points + self.analog) * (4 if self.real else 2)


def is_c3d(head: bytes) -> bool:
    """Return whether the first bytes of a file look like a C3D file."""
    return len(head) >= 2 and head[1] == MAGIC and 1 < head[0] < 128 and b"\0" in head


def read_c3d(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from a C3D file.

    Args:
        path: the file.
        unit: unit of length, in place of that in the file.

    Raises:
        RecordingError: the file is truncated or damaged, contains no points, or states no rate or unit.
    """
    data = read_bytes(path, LARGEST)
    try:
        parameters = read_parameters(data)
    except (ValueError, IndexError, struct.error) as error:
        hint = "export it again"
        raise RecordingError("the C3D file is damaged", received=error, hint=hint, file=path) from error
    layout = _layout(data, parameters, path)
    rate = parameters.number("POINT", "RATE") or float(floats(data[20:24], parameters.processor)[0])
    if not (rate > 0 and np.isfinite(rate)):
        raise RecordingError("POINT:RATE", expected="a rate in Hz", received=rate, hint="export it again", file=path)
    unit_name = unit or next(iter(parameters.texts("POINT", "UNITS")), "")
    unit_name = CUT_UNITS.get(unit_name.lower(), unit_name)
    labels = parameters.texts("POINT", "LABELS")[: layout.points]
    labels = [label or f"point {index + 1}" for index, label in enumerate(labels)]
    labels += [f"point {index + 1}" for index in range(len(labels), layout.points)]
    places = _places(parameters, labels)
    positions, all_marked = _positions(data, layout, parameters.processor)
    positions = positions[:, places] * metres(unit_name, None if unit else path)
    notes = [f"imported from {path.name} (C3D, {unit_name}, {rate:g} Hz)"]
    if all_marked:
        notes.append("every point of the file is marked as not seen (as Simi does); all points were used")
    if len(places) < layout.points:
        notes.append(f"{layout.points - len(places)} angles, forces and other model outputs were left out")
    return capture(
        path,
        "C3D" if not _maker(parameters) else f"C3D of {_maker(parameters)}",
        np.arange(len(positions)) / rate,
        [labels[place] for place in places],
        positions,
        up=_up(parameters),
        unit=unit_name,
        notes=notes,
    )


def _layout(data: bytes, parameters: Parameters, path: Path) -> Layout:
    """Return the layout on which header, parameters and size of the file agree."""
    order, processor = parameters.order, parameters.processor
    if len(data) < BLOCK:
        raise RecordingError("the file is truncated", expected="a header of 512 bytes", received=len(data), file=path)
    points, analog, first, last = struct.unpack_from(f"{order}4H", data, 2)
    block, samples = struct.unpack_from(f"{order}2H", data, 16)
    scale = _scale(float(floats(data[12:16], processor)[0]), parameters.number("POINT", "SCALE"), path)
    used = parameters.number("POINT", "USED")
    frames = _frames(parameters, last - first + 1 if last != TOO_LONG else 0)
    analogs = _analogs(parameters, analog, samples)
    starts = [(start - 1) * BLOCK for start in (block, int(parameters.number("POINT", "DATA_START") or 0)) if start > 1]
    counts = [int(count) for count in dict.fromkeys((points, used)) if count]
    shapes = [
        Layout(start, count, channels, number, scale < 0, abs(scale))
        for start in dict.fromkeys(starts)
        for count in counts
        for channels in analogs
        for number in frames or [max(1, (len(data) - start) // Layout(start, count, channels, 0, scale < 0, 1).stride)]
    ]
    if not shapes:
        raise RecordingError(
            "no marker in the file", expected="points", received=f"{points} points", hint="export the points too", file=path
        )
    left = [len(data) - shape.start - shape.frames * shape.stride for shape in shapes]
    fitting = next((shape for shape, rest in zip(shapes, left, strict=True) if 0 <= rest < BLOCK), None)
    if fitting is not None:
        return fitting
    if len({(shape.start, shape.stride) for shape in shapes}) == 1 and max(left) >= 0:
        return shapes[max(range(len(left)), key=lambda index: (left[index] >= 0, -left[index]))]
    raise _does_not_fit(shapes, left, len(data), path)


def _scale(header: float, parameter: float | None, path: Path) -> float:
    """Return the scale of the numbers, negative for 32-bit floats; header and parameter must agree where the scale is used."""
    hint = "export it again, with 32-bit numbers if possible"
    scale = header if parameter is None else parameter
    if not np.isfinite(scale) or scale == 0:
        raise RecordingError("POINT:SCALE", expected="a non-zero number", received=scale, hint=hint, file=path)
    other_kind = (header < 0) != (scale < 0)
    if np.isfinite(header) and header != 0 and (other_kind or (scale > 0 and abs(header - scale) > SAME_SCALE * scale)):
        expected, received = f"{header:.6g}, as in the header", f"{scale:.6g}"
        raise RecordingError("POINT:SCALE", expected=expected, received=received, hint=hint, file=path)
    return scale


def _does_not_fit(shapes: list[Layout], left: list[int], size: int, path: Path) -> RecordingError:
    shape = shapes[0]
    if max(left) < 0:
        there = max(0, size - shape.start) // shape.stride
        received, hint = f"{there} of {shape.frames} frames", "copy or export it again"
        return RecordingError("the file is truncated", expected="all frames", received=received, hint=hint, file=path)
    return RecordingError(
        "the layout of the file is inconsistent",
        expected=f"{size} bytes",
        received=" or ".join(str(one.start + one.frames * one.stride) for one in shapes[:4]),
        hint="header and parameters contradict each other about points or analog channels; export it again",
        file=path,
    )


def _frames(parameters: Parameters, header: int) -> list[int]:
    """Return the candidate numbers of frames, the most reliable first."""
    found = []
    start, end = (parameters.words("TRIAL", f"ACTUAL_{word}_FIELD") for word in ("START", "END"))
    if len(start) == len(end) == 2:
        found.append(end[0] + (end[1] << 16) - start[0] - (start[1] << 16) + 1)
    for name in ("LONG_FRAMES", "FRAMES"):
        number = parameters.number("POINT", name)
        if number is not None and np.isfinite(number) and abs(number) < 1e9:
            found.append(int(number) & 0xFFFF if number < 0 else int(number))
    return [number for number in dict.fromkeys([header, *found]) if number > 0 and number != TOO_LONG]


def _analogs(parameters: Parameters, header: int, samples: int) -> list[int]:
    """Return the candidate numbers of analog samples in a frame, from the header and from the parameters."""
    used = parameters.number("ANALOG", "USED") or 0.0
    rates = parameters.number("ANALOG", "RATE"), parameters.number("POINT", "RATE")
    found = [header, int(used) * samples]
    if all(rate is not None and np.isfinite(rate) and rate > 0 for rate in rates):
        found.append(int(used) * round((rates[0] or 0.0) / (rates[1] or 1.0)))
    return [number for number in dict.fromkeys(found) if 0 <= number < 1 << 20]


def _positions(data: bytes, layout: Layout, processor: int) -> tuple[NDArray[np.float64], bool]:
    """Return positions (T, K, 3) in the file's unit, NaN where not seen; and whether all are marked as not seen, but used."""
    width = 4 * layout.points
    raw = data[layout.start : layout.start + layout.frames * layout.stride]
    if layout.real:
        values: NDArray[Any] = floats(raw, processor).reshape(layout.frames, -1)[:, :width]
        scale = 1.0
    else:
        values = np.frombuffer(raw, ">i2" if processor == 86 else "<i2").reshape(layout.frames, -1)[:, :width]
        scale = layout.scale
    values = values.reshape(layout.frames, layout.points, 4)
    with np.errstate(invalid="ignore"):  # damaged files may contain invalid numbers
        positions = values[:, :, :3].astype(np.float64) * scale
    marked = values[:, :, 3] < 0
    all_marked = bool(marked.all()) and bool(values[:, :, :3].any())
    unseen = ~np.isfinite(positions).all(axis=2) | (np.abs(positions) > 1e9).any(axis=2)
    positions[unseen if all_marked else unseen | marked] = np.nan
    return positions, all_marked


def _places(parameters: Parameters, labels: list[str]) -> list[int]:
    """Return the indices of the points that are positions and not model outputs."""
    others = {label for name in NO_PLACES for label in parameters.texts("POINT", name) if label}
    return [index for index, label in enumerate(labels) if label not in others]


def _maker(parameters: Parameters) -> str:
    return " ".join(text for name in ("COMPANY", "SOFTWARE") for text in parameters.texts("MANUFACTURER", name)[:1] if text)[:60]


def _up(parameters: Parameters) -> Up:
    maker = _maker(parameters).lower()
    for word, (axis, system) in CONVENTIONS.items():
        if word in maker:
            return Up(axis, f"by the convention of {system}")
    screen = next(iter(parameters.texts("POINT", "Y_SCREEN")), "")
    if screen.lower() == "+z":
        return Up("+z", "by POINT:Y_SCREEN")
    return Up(None, f"the system is unknown, and POINT:Y_SCREEN ({screen or 'missing'}) is not reliable")
