"""Reading of commands over time from a CSV file: columns ``t,P1,P2``, ``t,tau`` or, for an arm in space, ``t,tau_x,tau_y``.

The units are s, bar and N m. Each command is held until the next row.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.recordings.grid import hold
from hsr_pin.recordings.text import Table, read_table
from hsr_pin.trajectory import Array

#: Candidate even steps [s], longest first; the first one that fits every row of the file is used.
STEPS = (0.01, 0.005, 0.002, 0.001)
#: Longest step of an evenly sampled file that is used as it is [s]; longer steps are held.
COARSEST = 0.02
#: Tolerance between the time of a row and an even instant [s].
TOLERANCE = 1e-6
#: Largest torque accepted [N m].
LARGEST_TORQUE = 1e3
#: Longest command [s].
LONGEST = 3600.0
_IN_SPACE = ("tau_x", "tau_y")


@dataclass(frozen=True, eq=False)
class CommandFile:
    """Evenly sampled commands.

    Attributes:
        time: (T,) [s].
        torque: (T,) [N m], in space (T, 2), or None.
        pressures: (T, 2) [bar], or None.
        note: one sentence if rows had to be moved, otherwise empty.
    """

    time: Array
    torque: Array | None
    pressures: Array | None
    note: str = ""


def read_commands(path: str | Path, *, max_pressure: float, duration: float | None = None) -> CommandFile:
    """Read commands from a file and sample them evenly.

    Args:
        path: the CSV file.
        max_pressure: largest accepted pressure [bar].
        duration: length of the run [s]; the last row is held, or later rows are left out; None: until the last row.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
        InputError: the duration is shorter than two samples, or too long.
    """
    table = read_table(Path(path))
    names = _inputs(table)
    _check(table, names, max_pressure)
    rows = table.column("t")
    span = rows[-1] - rows[0] if duration is None else duration
    step, exact = _step(rows)
    if not 2 * step <= span <= LONGEST:
        raise InputError("duration", expected=f"{2 * step:g} to {LONGEST:g} s", received=f"{span:g}")
    time = rows[0] + np.arange(round(span / step) + 1) * step
    held = hold(rows, np.stack([table.column(name) for name in names], axis=1), time + (TOLERANCE if exact else step / 2))
    note = "" if exact else f"rows of {path} were moved by up to {step / 2:g} s to even steps of {step:g} s"
    torque = held[:, 0] if names == ("tau",) else held if names == _IN_SPACE else None
    return CommandFile(time, torque, held if torque is None else None, note)


def _inputs(table: Table) -> tuple[str, ...]:
    for names in (("P1", "P2"), ("tau",), _IN_SPACE):
        if set(table.header) == {"t", *names}:
            return names
    raise table.fault("header", None, 0, expected="t,P1,P2 or t,tau or t,tau_x,tau_y", received=",".join(table.header)[:60])


def _check(table: Table, names: tuple[str, ...], max_pressure: float) -> None:
    low, high, unit = (0.0, max_pressure, "bar") if "P1" in names else (-LARGEST_TORQUE, LARGEST_TORQUE, "N m")
    for row in range(len(table.values)):
        for field, name in enumerate(table.header):
            value = table.values[row, field]
            if name != "t" and not low <= value <= high:
                received = "no value" if np.isnan(value) else f"{value:g}"
                raise table.fault(f"column {name}", row, field, expected=f"{low:g} to {high:g} {unit}", received=received)
            if name == "t" and np.isnan(value):
                raise table.fault("column t", row, field, expected="a time [s]", received="no value")
            if name == "t" and row and not value > table.values[row - 1, field]:
                before = f"more than {table.values[row - 1, field]:.9g} s, the previous time"
                raise table.fault("column t", row, field, expected=before, received=f"{value:.9g}")
    if len(table.values) < 2:
        raise table.fault("commands", 0, 0, expected="at least two rows", received="one")


def _step(rows: Array) -> tuple[float, bool]:
    """Return an even step [s], and whether the times of all rows are multiples of it."""
    elapsed = rows - rows[0]
    own = elapsed[-1] / (len(rows) - 1)
    for step in (*STEPS, own if own <= COARSEST else STEPS[-1]):
        if np.all(np.abs(elapsed - np.round(elapsed / step) * step) <= TOLERANCE):
            return float(step), True
    return STEPS[-1], False
