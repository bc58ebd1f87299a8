"""Phases of a run: at rest, just after a change of command, in transition, settled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

PHASES = ("rest", "command change", "transient", "settled")
#: Duration of the phase after a command change [s].
_AFTER_CHANGE = 0.15
#: Smallest change of command, relative to its range, that starts this phase.
_CHANGE = 0.02
#: An arm slower than this share of its largest speed is settled.
_SLOW = 0.03


def phases(run: Run, predicted: Array) -> NDArray[np.int_]:
    """Return the index (T,) into :data:`PHASES` of each sample, from the speed of the ``predicted`` markers (T, M, 3) [m]."""
    speed = np.abs(np.gradient(np.nan_to_num(predicted), run.step, axis=0)).max(axis=(1, 2))
    moving = speed > _SLOW * max(float(speed.max()), 1e-9)
    change = np.abs(np.diff(run.command, axis=0, prepend=run.command[:1])).max(axis=1)
    jumps = change > _CHANGE * max(run.span, 1e-9)
    starts = np.flatnonzero(jumps)
    if run.start_pose is not None:
        starts = np.append(0, starts)
    since = run.time[:, None] - run.time[starts][None, :] if len(starts) else np.full((len(run.time), 1), np.inf)
    changed = np.any((since >= 0) & (since < _AFTER_CHANGE), axis=1)
    begun = np.any(since >= 0, axis=1) & bool(len(starts))
    return np.select([changed, ~begun, moving], [1, 0, 2], default=3)
