"""Whether times can be those of a recorded motion, in seconds: asked before anything is computed from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array

#: Times between samples [s] that are taken. Slow motion from rest to rest may be sampled as slowly as this; steps of 1 and more
#: are those of cameras of 1 kHz and less, in milliseconds.
SHORTEST, LONGEST = 1e-5, 0.99
#: Longest recording [s].
LONGEST_RECORDING = 3600.0

_UNITS = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
#: Steps [s] that cameras and loggers have.
_USUAL = (LONGEST * 1e-3, 0.2)


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
        hint = "times are in seconds" if step < SHORTEST else "record faster, or slow motion at 0.99 s or less"
        if unit:
            hint = f"are these {unit}? then times are to be divided by {1 / _UNITS[unit]:g}"
        return Implausible(f"times in seconds, steps of {SHORTEST:g} to {LONGEST:g} s", f"steps of {step:.4g} s", hint)
    if duration > LONGEST_RECORDING * (1 + 1e-6):
        return Implausible(f"at most {LONGEST_RECORDING:g} s", f"{duration:.6g} s", "split the recording; times are in seconds")
    return None
