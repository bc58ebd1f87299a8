"""Reader of TSV exports of Qualisys Track Manager with 3D or 6DOF data (docs.qualisys.com, Motion data, 6DOF data).

Lines of a key and its values (``NO_OF_FRAMES``, ``FREQUENCY``, ``DATA_INCLUDED``, ``MARKER_NAMES`` or ``BODY_NAMES``, ...),
an optional line of columns (``Frame Time arm X arm Y ...``), then frames: optional number and time, three columns for each
marker or sixteen for each body, and possibly an empty column between bodies. Lengths are always in millimetres; z is up unless
the axes were changed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.sheet import Sheet, positive, read_sheet
from hsr_pin.recordings.importers.up import Up
from hsr_pin.trajectory import Array

UNIT = "mm"
#: Kinds of data with points: the key of the names, and the number of columns of each point.
KINDS = {"3D": ("MARKER_NAMES", 3), "6D": ("BODY_NAMES", 16)}
#: Number of rows from which columns without names are identified.
LOOK = 20
_KEYS = ("NO_OF_FRAMES", "FILE_VERSION", "NO_OF_CAMERAS")


def is_qualisys(head: str) -> bool:
    """Return whether the beginning of a text file looks like this format."""
    return head.lstrip('" \t').startswith(_KEYS)


def read_qualisys(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from a Qualisys file.

    Args:
        path: the file.
        unit: unit of length; None: millimetres.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    sheet = read_sheet(path)
    keys = _keys(sheet)
    kind = sheet.field(keys.get("DATA_INCLUDED", len(sheet)), 1)
    if kind not in KINDS:
        row, hint = keys.get("DATA_INCLUDED", 0), "export 3D data"
        raise sheet.fault(row, 1, "DATA_INCLUDED", expected=" or ".join(KINDS), received=repr(kind[:40]), hint=hint)
    key, width = KINDS[kind]
    if key not in keys:
        raise RecordingError(f"{key} is missing", expected="a line of names", hint="export with the TSV header", file=path)
    names = [name for name in sheet.row(keys[key])[1:] if name]
    rows = range(max(keys.values()) + 1, len(sheet))
    rate = positive(sheet.field(keys.get("FREQUENCY", len(sheet)), 1))
    before = _before(sheet, keys, rows, rate)
    if kind == "6D":
        width = _width(sheet, rows, len(before), len(names))
    columns = [len(before) + width * place + axis for place in range(len(names)) for axis in range(3)]
    values = sheet.numbers(rows, [*range(len(before)), *columns], before)
    stated = keys.get("NO_OF_FRAMES", len(sheet))
    sheet.check_count(rows, positive(sheet.field(stated, 1)), f"NO_OF_FRAMES in line {sheet.lines[min(stated, len(sheet) - 1)]}")
    time, note = _time(sheet, keys, values, before, rate)
    return capture(
        path,
        f"Qualisys TSV {kind}",
        time,
        names,
        values[:, len(before) :].reshape(len(rows), len(names), 3),
        up=Up("+z", "by the convention of Qualisys"),
        unit=unit or UNIT,
        factor=metres(unit or UNIT),
        notes=[f"imported from {path.name} (Qualisys TSV {kind}, {unit or UNIT})", *([note] if note else [])],
        encoding=sheet.encoding,
    )


def _keys(sheet: Sheet) -> dict[str, int]:
    """Return the row of each key; the line of columns, if present, is listed under its first word, such as ``Frame``."""
    keys: dict[str, int] = {}
    for row in range(len(sheet)):
        word = sheet.field(row, 0)
        if not word[:1].isalpha() or word.lower() == "nan":
            break
        keys[word] = row
    return keys


def _before(sheet: Sheet, keys: dict[str, int], rows: range, rate: float | None) -> list[str]:
    """Return the names of the columns before the first point, from the line of columns or from their numbers."""
    titles = [title.lower() for title in sheet.row(rows[0] - 1)[:2]] if rows else []
    if not any(word.endswith((" X", " x")) or word == "Frame" for word in keys):
        cells = [[(row, column) for column in (0, 1)] for row in rows[:LOOK]]
        first = np.array([[sheet.value(*cell) if sheet.is_number(*cell) else np.nan for cell in pair] for pair in cells])
        steps = np.diff(first, axis=0) if len(first) > 2 else np.zeros((1, 2))
        titles = ["frame"] if np.all(steps[:, 0] == 1) else []
        place = len(titles)
        if rate and place < 2 and np.all(np.abs(steps[:, place] - 1 / rate) < 1e-3 / rate + 2e-5):
            titles.append("time")
    return [title for title in titles if title in ("frame", "time")]


def _width(sheet: Sheet, rows: range, before: int, bodies: int) -> int:
    """Return the number of columns from body to body, including an empty column if the rows have one.

    Raises:
        RecordingError: the length of the rows fits neither case.
    """
    alone = KINDS["6D"][1]
    filled = [max((n for n, field in enumerate(sheet.row(row), 1) if field), default=0) for row in rows[:LOOK]]
    long = max(filled, default=0) - before
    for width in (alone, alone + 1):
        if long == width * bodies - (width - alone):
            return width
    expected, received = f"{alone} columns for each of {bodies} bodies", f"{long} in total"
    raise sheet.fault(rows[0], 0, "columns", expected=expected, received=received, hint="export 6D data again with all columns")


def _time(sheet: Sheet, keys: dict[str, int], values: Array, before: list[str], rate: float | None) -> tuple[Array, str]:
    frames = values[:, 0] if "frame" in before else np.arange(len(values), dtype=float)
    if "time" in before:
        return frame_times(frames, rate, values[:, before.index("time")])
    if rate is None:
        row, hint = keys.get("FREQUENCY", len(sheet)), "export the time column, or add the rate to the header"
        raise sheet.fault(row, 1, "FREQUENCY", expected="a rate in Hz", received=repr(sheet.field(row, 1)[:40]), hint=hint)
    return (frames - frames[:1]) / rate, ""
