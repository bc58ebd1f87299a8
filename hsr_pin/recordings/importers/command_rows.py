"""Input of a captured trial at its own times: ``t,P1,P2``, ``t,tau``, or the channels of an arm in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.grid import TOLERANCE, hold
from hsr_pin.recordings.sections import COMMAND
from hsr_pin.recordings.text import Table, nearest, read_table
from hsr_pin.trajectory import Array

#: Accepted inputs of an arm in a plane.
IN_PLANE = (("P1", "P2"), ("tau",))


@dataclass(frozen=True, eq=False)
class CommandRows:
    """Rows of commands as they are in the file.

    Attributes:
        path: the file.
        time: (R,) times [s] on the capture's clock, 0 at its first frame.
        names: ("P1", "P2") [bar] or ("tau",) [N m]; in space torques [N m] or channels in their own units.
        values: (R, len(names)) commands, or measured values.
        commanded: (R, len(names)) commands of measured values, NaN for a column without; None without any.
    """

    path: Path
    time: Array
    names: tuple[str, ...]
    values: Array
    commanded: Array | None = None

    @classmethod
    def of(cls, path: Path, time: Array, names: Sequence[str], values: Array) -> CommandRows:
        """Return the rows of columns (R, len(names)) of which some are the commands of others; gaps in commands are filled."""
        columns = dict(zip(names, values.T, strict=True))
        inputs = tuple(name for name in names if name.removesuffix(COMMAND) not in columns or not name.endswith(COMMAND))
        filled = {name: _filled(columns[f"{name}{COMMAND}"]) for name in inputs if f"{name}{COMMAND}" in columns}
        given = np.isfinite(np.stack([*(columns[name] for name in inputs), *filled.values()])).all(axis=0)
        measured = np.stack([columns[name] for name in inputs], axis=1)[given]
        if not filled:
            return cls(path, time[given], inputs, measured)
        nothing = np.full(len(time), np.nan)
        commanded = np.stack([filled.get(name, nothing) for name in inputs], axis=1)[given]
        return cls(path, time[given], inputs, measured, commanded)

    def held_at(self, time: Array) -> Array:
        """Return the commands (T, len(names)) at other times, each held until the next; before the first row, the first row."""
        step = (time[-1] - time[0]) / (len(time) - 1)
        return hold(self.time, self.values, time + TOLERANCE * step)

    def interpolated_at(self, time: Array) -> Array:
        """Return the commands (T, len(names)) at other times, interpolated linearly."""
        return np.stack([np.interp(time, self.time, column) for column in self.values.T], axis=1)

    def bending_command_at(self, time: Array) -> Array:
        """Return a quantity (T,) that rises with the commanded bending in a plane: torque, or P2 - P1 (Eq. (4) of the paper)."""
        held = self.held_at(time)
        return np.asarray(held[:, -1] - (held[:, 0] if len(self.names) == 2 else 0.0))


def _filled(column: Array) -> Array:
    """Return a column (R,) in which each gap holds the value before it."""
    last = np.maximum.accumulate(np.where(np.isfinite(column), np.arange(len(column)), 0))
    return column[last]


def read_command_rows(path: str | Path, inputs: Sequence[tuple[str, ...]] = IN_PLANE) -> CommandRows:
    """Read the rows of commands of an input file.

    Args:
        path: the file.
        inputs: accepted sets of columns in addition to ``t``; empty: any columns.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
    """
    table = read_table(Path(path))
    names = next((names for names in inputs if {"t", *names} <= set(table.header) <= _possible(names)), None)
    if not inputs and "t" in table.header and len(table.header) > 1:
        names = tuple(name for name in table.header if name != "t")
    if names is None:
        raise _other_columns(table, inputs)
    clock = np.array(table.header) == "t"  # times of any size; whether they overlap the motion is checked later
    gaps = np.argwhere(np.isnan(table.values) | ((np.abs(table.values) > 1e10) & ~clock))
    if gaps.size:
        row, field = (int(place) for place in gaps[0])
        raise table.fault(f"column {table.header[field]}", row, field, expected="a number", received=table.values[row, field])
    time = table.column("t")
    if np.any(np.diff(time) <= 0):
        row = int(np.argmax(np.diff(time) <= 0)) + 1
        raise table.fault("time", row, table.header.index("t"), expected="increasing", received=f"{time[row]:.9g} s")
    names = (*names, *(f"{name}{COMMAND}" for name in names if inputs and f"{name}{COMMAND}" in table.header))
    return CommandRows.of(table.path, time, names, np.stack([table.column(name) for name in names], axis=1))


def _possible(names: Sequence[str]) -> set[str]:
    return {"t", *names, *(f"{name}{COMMAND}" for name in names)}


def _other_columns(table: Table, inputs: Sequence[tuple[str, ...]]) -> RecordingError:
    known = ["t", *(name for names in inputs for name in names)]
    unknown = next((name for name in table.header if name not in known), None)
    hint, in_plane = nearest(unknown, known, "columns") if unknown else "", tuple(inputs) == IN_PLANE
    if in_plane and {"tau_x", "P3"} & set(table.header):
        hint = "for an arm in space give --bending space"
    elif not in_plane and "tau" not in "".join(table.header):
        hint = "declare the torque of each column with --gain or with [[input]] in --map"
    expected = " or ".join(",".join(["t", *names]) for names in inputs) or "t and a column for each input"
    field, received = table.header.index(unknown) if unknown else 0, ",".join(table.header)[:60]
    return table.fault("columns", None, field, expected=expected, received=received, hint=hint)
