"""The input of a captured trial: ``t,P1,P2`` or ``t,tau``, at times of its own, each row held until the next."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hsr_pin.recordings.grid import TOLERANCE, hold
from hsr_pin.recordings.text import nearest, read_table
from hsr_pin.trajectory import Array

#: The inputs there are.
INPUTS = (("P1", "P2"), ("tau",))


@dataclass(frozen=True, eq=False)
class CommandRows:
    """Rows as they stand in the file.

    Attributes:
        path: the file.
        time: (R,) [s] on the capture's clock, 0 at its first frame.
        names: ("P1", "P2") [bar] or ("tau",) [N m].
        values: (R, len(names)).
    """

    path: Path
    time: Array
    names: tuple[str, ...]
    values: Array

    def held_at(self, time: Array) -> Array:
        """(T, len(names)) at other times; before the first row, the first row."""
        step = (time[-1] - time[0]) / (len(time) - 1)
        return hold(self.time, self.values, time + TOLERANCE * step)

    def drive_at(self, time: Array) -> Array:
        """(T,) what rises with the commanded bending: the torque, or P2 above P1 (Eq. (4) of the paper)."""
        held = self.held_at(time)
        return np.asarray(held[:, -1] - (held[:, 0] if len(self.names) == 2 else 0.0))


def read_command_rows(path: str | Path) -> CommandRows:
    """Read an input.

    Raises:
        RecordingError: with file, line and column of the first fault.
    """
    table = read_table(Path(path))
    names = next((names for names in INPUTS if set(table.header) == {"t", *names}), None)
    if names is None:
        unknown = next((name for name in table.header if name not in ("t", "P1", "P2", "tau")), None)
        field = table.header.index(unknown) if unknown else 0
        hint = nearest(unknown, ("t", "P1", "P2", "tau"), "columns") if unknown else ""
        raise table.fault("columns", None, field, expected="t,P1,P2 or t,tau", received=",".join(table.header)[:60], hint=hint)
    gaps = np.argwhere(np.isnan(table.values) | (np.abs(table.values) > 1e10))
    if gaps.size:
        row, field = (int(place) for place in gaps[0])
        raise table.fault(f"column {table.header[field]}", row, field, expected="a number", received=table.values[row, field])
    time = table.column("t")
    if np.any(np.diff(time) <= 0):
        row = int(np.argmax(np.diff(time) <= 0)) + 1
        raise table.fault("time", row, table.header.index("t"), expected="increasing", received=f"{time[row]:.9g} s")
    return CommandRows(table.path, time, names, np.stack([table.column(name) for name in names], axis=1))
