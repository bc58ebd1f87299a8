"""Sample and hold: markers that repeat their last sample until a new one comes, as loggers write them that outrun cameras."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtrc

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
        f"{names}: sample and hold, a new position comes every {every:g} samples and is repeated to the last digit in between, "
        f"also while the arm moves: only the new ones count, each where it is seen first ({fresh} of {rows})"
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
    return jumps > 0 and bool(bdtrc(repeats - 1, jumps, 0.5) < LEVEL)


def clock(command: Array) -> int:
    """Samples between the instants at which alone a command (T, S) changes; 1 where it may change at any, by a sign test.

    Were a change as likely between those instants as at them, all N would be at them with a probability of 2^(1 - N).
    """
    changes = np.flatnonzero(np.diff(command, axis=0).any(axis=1))
    period = int(np.gcd.reduce(np.diff(changes))) if len(changes) > 1 else 1
    return period if 2.0 ** (1 - len(changes)) < LEVEL else 1


def unheld(command: Array) -> Array:
    """(T, S) a command that goes straight from one instant of its clock to the next."""
    if (period := clock(command)) == 1:
        return command
    first = int(np.argmax(np.diff(command, axis=0).any(axis=1))) + 1
    at = np.arange(len(command))
    known = at[(at - first) % period == 0]
    return np.stack([np.interp(at, known, column[known]) for column in command.T], axis=1)


def repeated(track: Array) -> NDArray[np.bool_]:
    """(T,) whether a sample of a track (T, 3) is the one before, in all coordinates and to the last digit."""
    return np.concatenate([[False], np.asarray((np.diff(track, axis=0) == 0).all(axis=1))])
