"""The input of a trial on the clock of its motion: moved as told or estimated, and refused where the two never meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, seen
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.mapping import TIME_UNITS
from hsr_pin.recordings.importers.settings import AUTO
from hsr_pin.recordings.lag import Lag, find_lag
from hsr_pin.trajectory import Array

#: Clocks of time zones differ by multiples of this [s].
ZONE = 900.0


def on_clock_of(
    command: CommandRows, capture: Capture, positions: Array, offset: float | str | None
) -> tuple[CommandRows, list[str]]:
    """The command on the clock of its recording, and notes.

    Args:
        command: as its file has it.
        capture: the recording.
        positions: (T, B, 3) [m] of its bodies, without spikes.
        offset: [s] that is added to the command's times; "auto": estimated; None: nothing is said.

    Raises:
        RecordingError: the command changes before or after the recording only, or does not tell its offset.
    """
    if offset == AUTO:
        lag = _lag(command, capture.time, positions)
        if lag is None or not lag.follows or lag.apart:
            many = f"several: {lag} explains {lag.share:.0%}, and so do others" if lag and lag.follows else "none"
            expected, hint = "one offset at which the motion follows from its input", "give the offset in s: --input-offset S"
            raise RecordingError("input offset", expected=expected, received=many, hint=hint, file=command.path)
        note = f"input moved by {lag}, which explains {lag.share:.0%} of the motion; a delay of the arm itself is lost in it"
        return replace(command, time=command.time + lag.value), [note]
    moved = replace(command, time=command.time + float(offset or 0.0))
    _check_overlap(moved, capture)
    if offset is not None:
        return moved, [f"input moved by {float(offset):g} s, as told"]
    lag = _lag(command, capture.time, positions)
    if lag is None or not lag.is_early:
        return moved, []
    said = f"the motion comes {abs(lag.value):.3g} s (+- {lag.sigma:.1g} s) before its command: is the clock of the input late?"
    return moved, [f"{said} then --input-offset {lag.value:.3g}, or auto"]


def _lag(command: CommandRows, time: Array, positions: Array) -> Lag | None:
    """Of the body that moves most, along its largest motion, and the column of the command that explains most of it."""
    tracks = [track for track in positions.swapaxes(0, 1) if seen(track).sum() > 2]
    if not tracks:
        return None
    most = max(tracks, key=lambda track: float(np.nanvar(track, axis=0).sum()))
    centred = most - np.nanmean(most, axis=0)
    motion = centred @ np.linalg.svd(centred[seen(most)], full_matrices=False)[2][0]
    values = command.values
    drives = [values[:, 1] - values[:, 0]] if command.names == ("P1", "P2") else list(values.T)
    found = [lag for drive in drives if (lag := find_lag(command.time, drive, time, motion)) is not None]
    return max(found, key=lambda lag: lag.share, default=None)


def _check_overlap(command: CommandRows, capture: Capture) -> None:
    """Refuse a command that changes, but never within the recording."""
    time, end = command.time, float(capture.time[-1])
    lasts = {unit: TIME_UNITS[unit] * float(time[-1] - time[0]) / end for unit in ("ms", "us", "ns")}
    unit = next((name for name, share in lasts.items() if 0.5 < share < 2), None)  # of the recording, were it in this unit
    if not np.ptp(command.values, axis=0).any() or (time[0] <= end and time[-1] >= 0 and unit is None):
        return
    if unit:
        hint = f"are these {unit}? say [input] time_unit in --map"
    elif hours := _near_zone(time, end):
        hint = f"its clock is {hours} h off: --input-offset {-3600 * float(hours):.0f}, or auto"
    elif time[0] > 1e8:
        hint = 'is it Unix time? say [input] time_unit and clock = "shared" in --map, or --input-offset auto for a time in s'
    else:
        hint = "move it with --input-offset S, or auto"
    expected = f"times of the recording, 0 to {end:.6g} s from its first frame"
    received = f"{time[0]:.9g} to {time[-1]:.9g} s"
    raise RecordingError("the clock of the input", expected=expected, received=received, hint=hint, file=command.path)


def _near_zone(time: Array, end: float) -> str:
    """The hours, a multiple of a quarter, by which a command's clock is off; empty where it is off by something else."""
    middle = (time[0] + time[-1]) / 2 - end / 2
    quarters = round(middle / ZONE)
    close = abs(middle - quarters * ZONE) <= min(max(end, float(time[-1] - time[0])), ZONE / 4)
    return f"{quarters * ZONE / 3600:g}" if quarters and abs(quarters) <= 56 and close else ""
