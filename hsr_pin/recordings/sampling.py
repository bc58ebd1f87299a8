"""Whether times can be those of a recorded motion, in seconds: asked before anything is computed from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array

#: No motion is recorded with fewer or more samples than one in so many seconds: an arm swings several times within the one.
SHORTEST, LONGEST = 1e-5, 0.5
#: Longest recording [s].
LONGEST_RECORDING = 3600.0

_UNITS = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
#: Steps [s] that cameras and loggers have.
_USUAL = (5e-4, 0.2)


@dataclass(frozen=True)
class Implausible:
    """Why times are not those of a motion: the facts of an error."""

    expected: str
    received: str
    hint: str


def implausible(time: Array) -> Implausible | None:
    """What is wrong with (T,) increasing times [s]; None: nothing."""
    step, duration = float(np.median(np.diff(time))), float(time[-1] - time[0])
    if not SHORTEST <= step <= LONGEST:
        unit = next((name for name, factor in _UNITS.items() if _USUAL[0] <= step * factor <= _USUAL[1]), None)
        hint = "times are in seconds" if step < SHORTEST else "an arm swings between such samples: record faster"
        if unit:
            hint = f"are these {unit}? then times are to be divided by {1 / _UNITS[unit]:g}"
        return Implausible(f"times in seconds, steps of {SHORTEST:g} to {LONGEST:g} s", f"steps of {step:.4g} s", hint)
    if duration > LONGEST_RECORDING * (1 + 1e-6):
        return Implausible(f"at most {LONGEST_RECORDING:g} s", f"{duration:.6g} s", "split the recording; times are in seconds")
    return None
