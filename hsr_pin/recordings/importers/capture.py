"""Common form of the files of all tracking systems: named points over time, in metres in the laboratory's frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.grid import GAP
from hsr_pin.recordings.importers.up import Up
from hsr_pin.recordings.sampling import implausible
from hsr_pin.trajectory import Array

#: Length of each unit [m], by its name in lower case.
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
    """Content of one file of a tracking system.

    Attributes:
        path: the file.
        system: name of the format.
        time: (T,) times [s], increasing, 0 at the first frame in the file.
        names: (K,) unique names of the points.
        positions: (T, K, 3) positions [m] in the laboratory's frame; NaN where not seen.
        up: upward axis of the laboratory according to the file.
        unit: unit of length in the file.
        start: time of the first frame on the clock of the file [s].
        notes: one sentence each.
        orientations: (T, 4) quaternion of each point that is a rigid body, real part first, from its axes to those of the
            laboratory; NaN where not seen.
    """

    path: Path
    system: str
    time: Array
    names: tuple[str, ...]
    positions: Array
    up: Up
    unit: str
    start: float = 0.0
    notes: tuple[str, ...] = ()
    orientations: Mapping[str, Array] = field(default_factory=dict)

    @property
    def rate(self) -> float:
        """Frame rate [Hz] where no frame is missing."""
        steps = np.diff(self.time)
        return float(1 / steps[steps <= GAP * np.median(steps)].mean())


def capture(
    path: Path,
    system: str,
    time: Array,
    names: Sequence[str],
    positions: Array,
    *,
    up: Up,
    unit: str,
    factor: float = 1.0,
    start: float = 0.0,
    notes: Sequence[str] = (),
    encoding: str = "",
    quaternions: Mapping[int, Array] | None = None,
    still_at_zero: bool = False,
) -> Capture:
    """Return a validated capture in which points not seen are NaN, names are unique, and time begins at 0.

    Args:
        path: the file.
        system: name of the format.
        up: upward axis of the laboratory according to the file.
        unit: unit of length in the file.
        start: time to add to ``time`` for the clock of the file [s].
        time: (T,) times [s].
        names: (K,) names of the points; a repeated name gets a number.
        positions: (T, K, 3) in ``unit``; a point at exactly (0, 0, 0) or with a missing coordinate was not seen.
        factor: metres per unit of length.
        notes: notes from reading.
        encoding: encoding of the text if not UTF-8.
        quaternions: (T, 4) unit quaternions of some points, by index in ``names``; one of length zero was not seen.
        still_at_zero: accept a point at (0, 0, 0) in every frame, such as the base of a table in the base's frame.

    Raises:
        RecordingError: there are no points or fewer than two frames, or the times do not increase or are implausible.
    """
    if not names:
        hint = "export the positions of markers or bodies too"
        raise RecordingError(
            "no marker in the file", expected="columns or labels of points", received="none", hint=hint, file=path
        )
    _check_time(path, time)
    notes = [*notes, f"read as {encoding}"] if encoding else list(notes)
    positions = np.array(positions, dtype=float)
    if factor != 1.0:
        positions *= factor
    positions = _with_flat_axes(positions, names, notes)
    zero = ~positions.any(axis=2)
    zero &= ~(still_at_zero & zero.all(axis=0))
    if zero.any():
        notes.append(f"{int(zero.sum())} samples at exactly (0, 0, 0) were taken as not seen")
    missing = np.isnan(positions)
    partial = missing.any(axis=2) & ~missing.all(axis=2)
    if partial.any():
        notes.append(f"{int(partial.sum())} samples with a missing coordinate were taken as not seen")
    if zero.any() or partial.any():
        positions[zero | partial] = np.nan
    named = _unique(names)
    turned = {named[k]: np.where(np.any(each, axis=1, keepdims=True), each, np.nan) for k, each in (quaternions or {}).items()}
    begin = start + float(time[0])
    return Capture(path, system, time - time[0], named, positions, up, unit, begin, tuple(notes), turned)


def _check_time(path: Path, time: Array) -> None:
    """Check that there are at least two frames and that their times increase and are plausible.

    Raises:
        RecordingError: the times are not valid.
    """
    if len(time) < 2:
        hint = "export the motion, not a single pose"
        raise RecordingError("recording", expected="at least two frames", received=len(time), hint=hint, file=path)
    steps = np.diff(time)
    if not np.all(steps > 0):
        frame = int(np.argmin(steps > 0)) + 1
        raise RecordingError("time", expected="increasing times", received=f"{time[frame]:.9g} s at frame {frame + 1}", file=path)
    facts = implausible(time)
    if facts is not None:
        raise RecordingError("time", **asdict(facts), file=path)


def _with_flat_axes(positions: Array, names: Sequence[str], notes: list[str]) -> Array:
    """Return positions with zeros for a coordinate that is missing in all frames while the others are present."""
    some = np.asarray(np.isfinite(positions).any(axis=0), dtype=bool)
    flat: NDArray[np.bool_] = ~some & (some.sum(axis=1, keepdims=True) == 2)
    for point, axis in np.argwhere(flat):
        notes.append(f"{names[point]}: {'xyz'[axis]} is missing in all frames and was set to 0 (camera that sees a plane)")
    return np.where(flat & np.isfinite(positions).any(axis=2, keepdims=True), 0.0, positions)


def seen(positions: Array) -> NDArray[np.bool_]:
    """Return whether (...) positions (..., 3) are complete."""
    return np.asarray(np.isfinite(positions).all(axis=-1), dtype=bool)


def metres(unit: str, path: Path | None = None, line: int | None = None, column: int | None = None) -> float:
    """Return the length of a unit [m].

    Raises:
        InputError: the text is not a unit of length (a :class:`~hsr_pin.errors.RecordingError` with line and column if it is in
            a file).
    """
    factor = UNITS.get(unit.strip().lower())
    if factor is None:
        expected = "one of " + ", ".join(UNITS)
        if path is None:
            raise InputError("unit", expected=expected, received=repr(unit))
        raise RecordingError(
            "unit", expected=expected, received=repr(unit[:40]), hint="give it with --unit", file=path, line=line, column=column
        )
    return factor


def _unique(names: Sequence[str]) -> tuple[str, ...]:
    taken: dict[str, int] = {}
    for name in ("".join(letter if letter.isprintable() else "?" for letter in name) for name in names):
        number, candidate = taken.get(name, 0) + 1, name
        while candidate in taken:
            number += 1
            candidate = f"{name} #{number}"
        taken[candidate] = 1
        taken[name] = max(taken[name], number) if name in taken else number
    return tuple(taken)
