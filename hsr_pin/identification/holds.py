"""Sample and hold: markers that repeat their last sample until a new one comes, as loggers write them that outrun cameras."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from hsr_pin.trajectory import Array, Dataset

#: Level of the test: with which probability a recording without repeats is taken for one with them.
LEVEL = 1e-6
#: A jump that cannot be one step of the last digit: of so many of them, and more.
_JUMP = 1.5


def without_repeats(dataset: Dataset, markers: list[int]) -> tuple[Dataset, str]:
    """A dataset whose repeated samples are gaps, and a note on them; the same and no note where nothing is held.

    The sample that a logger repeats came at the row in which it is seen first, or up to one row before: it counts there.

    Args:
        dataset: as read; a repeat is one to the last digit, so that nothing may have been resampled since.
        markers: that tell about bending; each of them is held or not.
    """
    held = [marker for marker in markers if is_held([trial.trajectory.positions[:, marker] for trial in dataset.trials])]
    if not held:
        return dataset, ""
    trials, spans, rows = [], [np.zeros(0, dtype=np.intp)], 0
    for trial in dataset.trials:
        positions = trial.trajectory.positions.copy()
        again = np.stack([repeated(positions[:, marker]) for marker in held], axis=1)
        rows += again.size
        spans += [np.diff(np.flatnonzero(~column)) for column in again.T]
        for column, marker in enumerate(held):
            positions[again[:, column], marker] = np.nan
        trials.append(replace(trial, trajectory=replace(trial.trajectory, positions=positions)))
    names = ", ".join(dataset.markers[marker].name for marker in held)
    every = np.concatenate(spans)
    note = (
        f"{names}: sample and hold, a new position comes every {np.median(every):g} samples and is repeated to the last digit "
        f"in between, also while the arm moves: only the new ones count, each where it is seen first ({len(every)} of {rows})"
    )
    return replace(dataset, trials=tuple(trials)), note


def is_held(tracks: list[Array]) -> bool:
    """Whether a marker is sampled and held: a sign test of level :data:`LEVEL`.

    After a jump of two steps of the last digit or more, in any coordinate, the arm moves or its noise is not below that digit:
    a new sample would be the same in all three coordinates less often than not. A coarse one of a resting arm has no such jumps.

    Args:
        tracks: (T, 3) [m] of the marker in each trial, as written.
    """
    steps = [np.abs(np.diff(track, axis=0)) for track in tracks]
    changed = np.concatenate([step[step > 0] for step in steps])
    if not len(changed):
        return False
    digit, jumps, repeats = float(changed.min()), 0, 0
    for track, step in zip(tracks, steps, strict=True):
        jump = np.asarray((step > _JUMP * digit).any(axis=1))[:-1]
        jumps, repeats = jumps + int(jump.sum()), repeats + int((jump & repeated(track)[2:]).sum())
    return jumps > 0 and bool(binomtest(repeats, jumps, 0.5, alternative="greater").pvalue < LEVEL)


def repeated(track: Array) -> NDArray[np.bool_]:
    """(T,) whether a sample of a track (T, 3) is the one before, in all coordinates and to the last digit."""
    return np.concatenate([[False], np.asarray((np.diff(track, axis=0) == 0).all(axis=1))])
