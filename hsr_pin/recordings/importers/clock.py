"""When each frame was taken: from its number and the rate, for times are often printed with too few digits."""

from __future__ import annotations

import numpy as np

from hsr_pin.recordings.grid import ROUNDED, fit, last_digit
from hsr_pin.trajectory import Array

#: Times with more digits than this [s] are as good as frame numbers.
FINE = 1e-6
#: Recordings of fewer last digits than this cannot tell a rounded time from one at another rate.
TELLING = 10.0


def frame_times(frames: Array, rate: float | None, stamps: Array) -> tuple[Array, str]:
    """(T,) [s] the time of each frame, and a sentence where that is not simply its stamp.

    Args:
        frames: (T,) numbers, increasing.
        rate: of the frames [Hz], as the file has it; None: not said.
        stamps: (T,) [s] as printed.
    """
    if len(frames) < 2 or np.any(np.diff(frames) <= 0) or np.any(np.diff(stamps) < 0):
        return stamps, ""
    spacing = float(np.spacing(np.abs(stamps).max()))
    digit = max(last_digit(stamps, spacing), FINE)
    if stamps[-1] - stamps[0] < TELLING * digit and np.all(np.diff(stamps) > 0):
        return stamps, ""
    slack = ROUNDED * digit + 4 * spacing
    for step in (1 / rate if rate else None, fit(frames, stamps)[0]):
        if step is None:
            continue
        time = (frames - frames[0]) * step
        off = stamps - time
        if np.ptp(off) <= 2 * slack:
            rounded = float(np.abs(off - off.mean()).max()) > FINE
            return time + stamps[
                0
            ], f"time from frame numbers at {1 / step:.6g} Hz: the times in the file are rounded" if rounded else ""
    said = f", at {rate:g} Hz," if rate else ""
    return stamps, f"time as printed: the frame numbers{said} do not keep step with it"
