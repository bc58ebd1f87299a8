"""Alignment of the input of a trial with the clock of its motion, by a given or an estimated time offset."""

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

#: Time-zone offsets are multiples of this [s].
ZONE = 900.0


def on_clock_of(
    command: CommandRows, capture: Capture, positions: Array, offset: float | str | None
) -> tuple[CommandRows, list[str]]:
    """Return the command on the clock of its recording, and notes.

    Args:
        command: the command with the times of its file.
        capture: the recording.
        positions: (T, B, 3) positions [m] of the bodies, without spikes.
        offset: time added to the command's times [s]; "auto": estimated; None: not given.

    Raises:
        RecordingError: the command does not change within the recording, or its offset cannot be estimated.
    """
    if offset == AUTO:
        lag = _lag(command, capture.time, positions)
        if lag is None or not lag.follows or lag.ambiguous:
            many = f"several: {lag} explains {lag.share:.0%} of the motion, and so do others" if lag and lag.follows else "none"
            expected, hint = "one offset at which the input explains the motion", "give the offset in s: --input-offset S"
            raise RecordingError("input offset", expected=expected, received=many, hint=hint, file=command.path)
        note = f"input moved by {lag}, which explains {lag.share:.0%} of the motion; this removes a delay of the arm itself"
        return replace(command, time=command.time + lag.value), [note]
    moved = replace(command, time=command.time + float(offset or 0.0))
    _check_overlap(moved, capture)
    if offset is not None:
        return moved, [f"input moved by {float(offset):g} s, as given"]
    lag = _lag(command, capture.time, positions)
    if lag is None or not lag.is_early:
        return moved, []
    lead = f"the motion leads its command by {abs(lag.value):.3g} s (+- {lag.sigma:.1g} s)"
    return moved, [f"{lead}; if the clock of the input is late, give --input-offset {lag.value:.3g}, or auto"]


def _lag(command: CommandRows, time: Array, positions: Array) -> Lag | None:
    """Estimate the delay from the largest motion of any body and the input column that explains it best."""
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
    """Check that a command that changes does so within the recording."""
    time, end = command.time, float(capture.time[-1])
    lasts = {unit: TIME_UNITS[unit] * float(time[-1] - time[0]) / end for unit in ("ms", "us", "ns")}
    unit = next((name for name, share in lasts.items() if 0.5 < share < 2), None)  # share of the recording, in this unit
    if not np.ptp(command.values, axis=0).any() or (time[0] <= end and time[-1] >= 0 and unit is None):
        return
    if unit:
        hint = f"if these are {unit}, give [input] time_unit in --map"
    elif hours := _near_zone(time, end):
        hint = f"its clock is {hours} h off; give --input-offset {-3600 * float(hours):.0f}, or auto"
    elif time[0] > 1e8:
        hint = 'for Unix time give [input] time_unit and clock = "shared" in --map, or --input-offset auto'
    else:
        hint = "correct it with --input-offset S, or auto"
    expected = f"times of the recording, 0 to {end:.6g} s from its first frame"
    received = f"{time[0]:.9g} to {time[-1]:.9g} s"
    raise RecordingError("the clock of the input", expected=expected, received=received, hint=hint, file=command.path)


def _near_zone(time: Array, end: float) -> str:
    """Return the time-zone offset [h] of a command's clock as text; empty if the offset is not a multiple of a quarter hour."""
    middle = (time[0] + time[-1]) / 2 - end / 2
    quarters = round(middle / ZONE)
    close = abs(middle - quarters * ZONE) <= min(max(end, float(time[-1] - time[0])), ZONE / 4)
    return f"{quarters * ZONE / 3600:g}" if quarters and abs(quarters) <= 56 and close else ""
