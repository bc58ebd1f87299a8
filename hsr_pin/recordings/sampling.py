"""Plausibility check of recorded times [s], made before anything is computed from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array

#: Accepted times between samples [s]. The upper limit still admits slow motion from rest to rest; steps of 1 or more are
#: more likely those of a camera at 1 kHz or less, given in milliseconds.
SHORTEST, LONGEST = 1e-5, 0.99
#: Longest recording [s].
LONGEST_RECORDING = 3600.0

_UNITS = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
#: Typical steps of cameras and loggers [s].
_USUAL = (LONGEST * 1e-3, 0.2)


@dataclass(frozen=True)
class Implausible:
    """Reason why times cannot be those of a recorded motion, as the parts of an error message."""

    expected: str
    received: str
    hint: str


def implausible(time: Array) -> Implausible | None:
    """Return why increasing times (T,) [s] are implausible; None if they are plausible."""
    step, duration = float(np.median(np.diff(time))), float(time[-1] - time[0])
    if not SHORTEST <= step <= LONGEST:
        unit = next((name for name, factor in _UNITS.items() if _USUAL[0] <= step * factor <= _USUAL[1]), None)
        hint = "times are in seconds" if step < SHORTEST else "record with a step of 0.99 s or less"
        if unit:
            hint = f"if these are {unit}, divide the times by {1 / _UNITS[unit]:g}"
        return Implausible(f"times in seconds with steps of {SHORTEST:g} to {LONGEST:g} s", f"steps of {step:.4g} s", hint)
    if duration > LONGEST_RECORDING * (1 + 1e-6):
        return Implausible(
            f"a duration of at most {LONGEST_RECORDING:g} s", f"{duration:.6g} s", "split the recording; times are in seconds"
        )
    return None
