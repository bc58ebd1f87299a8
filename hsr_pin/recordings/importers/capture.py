"""What every tracking system's file comes down to: named points over time, in metres, in the laboratory's frame."""

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
        up: what the file tells about the laboratory's axis that points upwards.
        unit: of length in the file.
        start: [s] the first frame on the clock of the file.
        notes: one sentence each.
        orientations: (T, 4) of each point that is a rigid body: the quaternion, real part first, that takes its axes to the
            laboratory's; NaN where not seen.
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
        """Frames in a second [Hz], where none is missing."""
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
    turns: Mapping[int, Array] | None = None,
    still_at_zero: bool = False,
) -> Capture:
    """A capture that has been looked through: points that are not seen are NaN, names are unique, time begins at 0.

    Args:
        path: as in :class:`Capture`.
        system: likewise.
        up: likewise.
        unit: likewise.
        start: [s] to be added to the times for those on the clock of the file.
        time: (T,) [s].
        names: (K,) a name that comes again is given a number.
        positions: (T, K, 3); a point at exactly (0, 0, 0), or with a coordinate missing, was not seen.
        factor: metres in one of their unit.
        notes: so far.
        encoding: of the text, if not UTF-8.
        turns: (T, 4) quaternions of some points, by their place in ``names``; one of length zero was not seen.
        still_at_zero: a point that is at (0, 0, 0) in every frame stands there: the base of a table in the base's frame.

    Raises:
        RecordingError: no point, fewer than two frames, or time that does not increase or is not that of a motion.
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
        notes.append(f"{int(partial.sum())} samples with a coordinate missing were taken as not seen")
    if zero.any() or partial.any():
        positions[zero | partial] = np.nan
    named = _unique(names)
    turned = {named[k]: np.where(np.any(each, axis=1, keepdims=True), each, np.nan) for k, each in (turns or {}).items()}
    begin = start + float(time[0])
    return Capture(path, system, time - time[0], named, positions, up, unit, begin, tuple(notes), turned)


def _check_time(path: Path, time: Array) -> None:
    """Refuse fewer than two frames, and times that do not increase or are not those of a motion.

    Raises:
        RecordingError: they are.
    """
    if len(time) < 2:
        hint = "export the motion, not one pose"
        raise RecordingError("recording", expected="at least two frames", received=len(time), hint=hint, file=path)
    steps = np.diff(time)
    if not np.all(steps > 0):
        frame = int(np.argmin(steps > 0)) + 1
        raise RecordingError("time", expected="frames in order", received=f"{time[frame]:.9g} s at frame {frame + 1}", file=path)
    facts = implausible(time)
    if facts is not None:
        raise RecordingError("time", **asdict(facts), file=path)


def _with_flat_axes(positions: Array, names: Sequence[str], notes: list[str]) -> Array:
    """Positions in which the one coordinate of a point that no frame has, while it has the others, is zero."""
    some = np.asarray(np.isfinite(positions).any(axis=0), dtype=bool)
    flat: NDArray[np.bool_] = ~some & (some.sum(axis=1, keepdims=True) == 2)
    for point, axis in np.argwhere(flat):
        notes.append(f"{names[point]}: no {'xyz'[axis]} in any frame, taken as 0 (of a camera that sees a plane)")
    return np.where(flat & np.isfinite(positions).any(axis=2, keepdims=True), 0.0, positions)


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
    taken: dict[str, int] = {}
    for name in ("".join(letter if letter.isprintable() else "?" for letter in name) for name in names):
        number, candidate = taken.get(name, 0) + 1, name
        while candidate in taken:
            number += 1
            candidate = f"{name} #{number}"
        taken[candidate] = 1
        taken[name] = max(taken[name], number) if name in taken else number
    return tuple(taken)
