"""Computation of frame times from frame numbers and the rate, as printed times are often rounded."""

from __future__ import annotations

import numpy as np

from hsr_pin.recordings.grid import ROUNDED, fit, last_digit
from hsr_pin.trajectory import Array

#: Printed times with a finer resolution than this [s] are as precise as frame numbers.
FINE = 1e-6
#: Shortest recording, in units of the last digit, in which rounded times can be told from times at another rate.
SHORTEST = 10.0


def frame_times(frames: Array, rate: float | None, stamps: Array) -> tuple[Array, str]:
    """Return the time (T,) [s] of each frame, and a sentence if it differs from the printed time.

    Args:
        frames: (T,) frame numbers, increasing.
        rate: frame rate of the file [Hz]; None: not given.
        stamps: (T,) printed times [s].
    """
    if len(frames) < 2 or np.any(np.diff(frames) <= 0) or np.any(np.diff(stamps) < 0):
        return stamps, ""
    spacing = float(np.spacing(np.abs(stamps).max()))
    digit = max(last_digit(stamps, spacing), FINE)
    if stamps[-1] - stamps[0] < SHORTEST * digit and np.all(np.diff(stamps) > 0):
        return stamps, ""
    slack = ROUNDED * digit + 4 * spacing
    for step in (1 / rate if rate else None, fit(frames, stamps)[0]):
        if step is None:
            continue
        time = (frames - frames[0]) * step
        off = stamps - time
        if np.ptp(off) <= 2 * slack:
            rounded = float(np.abs(off - off.mean()).max()) > FINE
            note = f"times from frame numbers at {1 / step:.6g} Hz, as the times in the file are rounded"
            return time + stamps[0], note if rounded else ""
    stated = f", at {rate:g} Hz," if rate else ""
    return stamps, f"times as printed, as the frame numbers{stated} do not agree with them"
