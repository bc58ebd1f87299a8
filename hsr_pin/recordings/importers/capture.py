"""What every tracking system's file comes down to: named points over time, in metres, in the laboratory's frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.trajectory import Array

#: Names of length units, in lower case, in metres.
UNITS = {
    "m": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "metres": 1.0,
    "cm": 1e-2,
    "centimeters": 1e-2,
    "centimetres": 1e-2,
    "mm": 1e-3,
    "millimeters": 1e-3,
    "millimetres": 1e-3,
    "in": 0.0254,
    "inches": 0.0254,
}


@dataclass(frozen=True, eq=False)
class Capture:
    """One file of a tracking system.

    Attributes:
        path: the file.
        system: what wrote it.
        time: (T,) [s], increasing, from 0 at the first frame in the file.
        names: (K,) of the points, each once, as the system has them.
        positions: (T, K, 3) [m] in the laboratory's frame; NaN where not seen.
        up: the laboratory's axis that this system has upwards unless told otherwise (``"+z"``).
        notes: one sentence each.
    """

    path: Path
    system: str
    time: Array
    names: tuple[str, ...]
    positions: Array
    up: str
    notes: tuple[str, ...] = ()


def capture(
    path: Path, system: str, time: Array, names: Sequence[str], positions: Array, *, up: str, notes: Sequence[str] = ()
) -> Capture:
    """A capture that has been looked through: points that are not seen are NaN, names are unique, time begins at 0.

    Args:
        path: as in :class:`Capture`.
        system: likewise.
        up: likewise.
        time: (T,) [s].
        names: (K,) a name that comes again is given a number.
        positions: (T, K, 3) [m]; a point at exactly (0, 0, 0), or with a coordinate missing, was not seen.
        notes: so far.

    Raises:
        RecordingError: no point, fewer than two frames, or time that does not increase.
    """
    if not names:
        raise RecordingError("no marker in the file", expected="columns or labels of points", file=path)
    if len(time) < 2:
        raise RecordingError("recording", expected="at least two frames", received=len(time), file=path)
    steps = np.diff(time)
    if not np.all(steps > 0):
        frame = int(np.argmin(steps > 0)) + 1
        raise RecordingError("time", expected="frames in order", received=f"{time[frame]:.9g} s at frame {frame + 1}", file=path)
    notes = list(notes)
    positions = np.array(positions, dtype=float)
    zero = np.all(positions == 0, axis=2)
    if zero.any():
        notes.append(f"{int(zero.sum())} samples at exactly (0, 0, 0) were taken as not seen")
    partial = np.isnan(positions).any(axis=2) & ~np.isnan(positions).all(axis=2)
    if partial.any():
        notes.append(f"{int(partial.sum())} samples with a coordinate missing were taken as not seen")
    positions[zero | partial] = np.nan
    return Capture(path, system, time - time[0], _unique(names), positions, up, tuple(notes))


def seen(positions: Array) -> NDArray[np.bool_]:
    """(...) whether (..., 3) positions are whole."""
    return np.asarray(np.isfinite(positions).all(axis=-1), dtype=bool)


def metres(unit: str, path: Path | None = None, line: int | None = None, column: int | None = None) -> float:
    """How many metres one of a unit is.

    Raises:
        InputError: not a unit of length (a :class:`~hsr_pin.errors.RecordingError` with its place if it stands in a file).
    """
    factor = UNITS.get(unit.strip().lower())
    if factor is None:
        expected = "one of " + ", ".join(UNITS)
        if path is None:
            raise InputError("unit", expected=expected, received=repr(unit))
        raise RecordingError(
            "unit", expected=expected, received=repr(unit[:40]), hint="say it with --unit", file=path, line=line, column=column
        )
    return factor


def _unique(names: Sequence[str]) -> tuple[str, ...]:
    taken: list[str] = []
    for name in names:
        number, candidate = 2, name
        while candidate in taken:
            candidate, number = f"{name} #{number}", number + 1
        taken.append(candidate)
    return tuple(taken)
