"""Sample and hold: markers whose last sample is repeated until a new one arrives, if the logger is faster than the cameras."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtrc

from hsr_pin.trajectory import Array, Dataset

#: Level of the test: the probability that a recording without repeats is taken for one with repeats.
LEVEL = 1e-6
#: Smallest change, in steps of the last digit, that is larger than one step.
_JUMP = 1.5


def without_repeats(dataset: Dataset, markers: list[int]) -> tuple[Dataset, str]:
    """Return a dataset whose repeated samples are gaps, and a note about them; unchanged and without a note if nothing is held.

    The sample that a logger repeats was taken at the row in which it first occurs, or up to one row before; it is assigned to
    that row.

    Args:
        dataset: the dataset as read; repeats are exact, so that the data must not have been resampled.
        markers: the markers that depend on bending; each of them is held or not.
    """
    held = [marker for marker in markers if is_held([trial.trajectory.positions[:, marker] for trial in dataset.trials])]
    if not held:
        return dataset, ""
    trials, spans, rows, fresh = [], [np.zeros(0, dtype=np.intp)], 0, 0
    for trial in dataset.trials:
        positions = trial.trajectory.positions.copy()
        again = np.stack([repeated(positions[:, marker]) for marker in held], axis=1)
        rows, fresh = rows + again.size, fresh + int((~again).sum())
        spans += [np.diff(np.flatnonzero(~column)) for column in again.T]
        for column, marker in enumerate(held):
            positions[again[:, column], marker] = np.nan
        trials.append(replace(trial, trajectory=replace(trial.trajectory, positions=positions)))
    names = ", ".join(dataset.markers[marker].name for marker in held)
    every = float(np.median(np.concatenate(spans)))
    note = (
        f"{names}: sample and hold; a new position is recorded every {every:g} samples and repeated exactly in between, also "
        f"while the arm moves; only new positions are used, each at its first sample ({fresh} of {rows})"
    )
    return replace(dataset, trials=tuple(trials)), note


def is_held(tracks: list[Array]) -> bool:
    """Return whether a marker is sampled and held, by a sign test of level :data:`LEVEL`.

    After a change of at least two steps of the last digit, in any coordinate, the arm moves or its noise is larger than that
    digit: a new sample would then be equal in all three coordinates less often than not. Coarsely rounded samples of a resting
    arm have no such changes.

    Args:
        tracks: (T, 3) positions of the marker in each trial, as written [m].
    """
    steps = [np.abs(np.diff(track, axis=0)) for track in tracks]
    changed = np.concatenate([step[step > 0] for step in steps])
    if not len(changed):
        return False
    digit, jumps, repeats = float(changed.min()), 0, 0
    for track, step in zip(tracks, steps, strict=True):
        jump = np.asarray((step > _JUMP * digit).any(axis=1))[:-1]
        jumps, repeats = jumps + int(jump.sum()), repeats + int((jump & repeated(track)[2:]).sum())
    return jumps > 0 and bool(bdtrc(repeats - 1, jumps, 0.5) < LEVEL)


def clock(command: Array) -> int:
    """Return the number of samples between the instants at which a command (T, S) changes; 1 if it may change at any sample.

    The decision is a sign test: if changes between those instants were as likely, all N changes would be at them with a
    probability of 2^(1 - N).
    """
    changes = np.flatnonzero(np.diff(command, axis=0).any(axis=1))
    period = int(np.gcd.reduce(np.diff(changes))) if len(changes) > 1 else 1
    return period if 2.0 ** (1 - len(changes)) < LEVEL else 1


def without_holds(command: Array) -> Array:
    """Return a command (T, S) that is interpolated linearly between the instants of its clock."""
    if (period := clock(command)) == 1:
        return command
    first = int(np.argmax(np.diff(command, axis=0).any(axis=1))) + 1
    at = np.arange(len(command))
    known = at[(at - first) % period == 0]
    return np.stack([np.interp(at, known, column[known]) for column in command.T], axis=1)


def repeated(track: Array) -> NDArray[np.bool_]:
    """Return whether each sample (T,) of a track (T, 3) equals the one before exactly, in all coordinates."""
    return np.concatenate([[False], np.asarray((np.diff(track, axis=0) == 0).all(axis=1))])
