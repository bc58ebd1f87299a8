"""Cleaning of recordings: errors of the tracking system become gaps, and notes report them. Files are not changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError
from hsr_pin.recordings.grid import evened, on_even_grid
from hsr_pin.recordings.noise import noise_floor
from hsr_pin.recordings.outliers import exchanges, spikes
from hsr_pin.trajectory import Array, Dataset, Trajectory, Trial

__all__ = ["clean", "moving_average", "noise_floor"]

Recording = TypeVar("Recording", Trajectory, Trial, Dataset)


def clean(
    recording: Recording,
    *,
    remove_spikes: bool = True,
    restore_exchanges: bool = True,
    threshold: float = 5.0,
    half_window: int = 5,
    smoothing: int | None = None,
    long_gap: float = 0.1,
) -> Recording:
    """Return a recording without the spikes and the exchanged markers of the tracking system.

    Args:
        recording: a trajectory, a trial, or a dataset.
        remove_spikes: replace samples far from their neighbours by gaps (:func:`~hsr_pin.recordings.outliers.spikes`).
        restore_exchanges: restore the names of markers that were exchanged.
        threshold: threshold for spikes, in standard deviations.
        half_window: number of samples on either side with which a sample is compared.
        smoothing: width of a moving average, an odd number of samples, as used in the paper; None: no smoothing. Smoothing
            attenuates fast motion.
        long_gap: duration [s] from which gaps are reported.

    Returns:
        The cleaned recording at even times; the ``notes`` of each trajectory list the changes.

    Raises:
        InputError: ``smoothing`` is not an odd number of samples, ``half_window`` or ``threshold`` is not positive, or sampling
            is so uneven that almost all of an even grid would be gaps.
    """
    if smoothing is not None and (smoothing < 1 or smoothing % 2 == 0):
        raise InputError("smoothing", expected="an odd number of samples", received=smoothing)
    if half_window < 1 or not threshold > 0:
        raise InputError(
            "spikes", expected="half_window of at least 1, threshold above 0", received=f"{half_window}, {threshold}"
        )

    def cleaned(trajectory: Trajectory) -> Trajectory:
        positions, notes = np.array(trajectory.positions), list(trajectory.notes)
        if restore_exchanges:
            positions = _restore(positions, trajectory, notes)
        if remove_spikes:
            positions = _without_spikes(positions, trajectory, notes, threshold, half_window)
        _report_gaps(positions, trajectory, notes, long_gap)
        if smoothing is not None and smoothing > 1:
            positions = moving_average(positions, smoothing)
            notes.append(f"smoothed with a moving average of {smoothing} samples")
        return replace(trajectory, positions=positions, notes=tuple(dict.fromkeys(notes)))

    return cast(Recording, _with_each_trajectory(recording, cleaned))


def _with_each_trajectory(
    recording: Trajectory | Trial | Dataset, change: Callable[[Trajectory], Trajectory]
) -> Trajectory | Trial | Dataset:
    if isinstance(recording, Dataset):
        return replace(recording, trials=tuple(cast(Trial, _with_each_trajectory(trial, change)) for trial in recording.trials))
    try:
        even = evened(recording) if isinstance(recording, Trial) else on_even_grid(recording)[0]
    except ValueError as error:
        hint = "split the recording at long pauses"
        raise InputError("time", expected="nearly even sampling", received=error, hint=hint) from error
    return replace(even, trajectory=change(even.trajectory)) if isinstance(even, Trial) else change(even)


def moving_average(positions: Array, width: int) -> Array:
    """Return the centred moving average (T, M, 3) over ``width`` samples, fewer towards the ends; gaps remain gaps."""
    samples = len(positions)
    seen = np.isfinite(positions)
    total = np.concatenate([np.zeros((1, *positions.shape[1:])), np.cumsum(np.where(seen, positions, 0.0), axis=0)])
    count = np.concatenate([np.zeros((1, *positions.shape[1:])), np.cumsum(seen, axis=0)])
    index = np.arange(samples)
    half = np.minimum(np.minimum(index, samples - 1 - index), width // 2)
    number = count[index + half + 1] - count[index - half]
    mean = (total[index + half + 1] - total[index - half]) / np.where(number == 0, 1, number)
    return np.where(seen, mean, np.nan)


def _restore(positions: Array, trajectory: Trajectory, notes: list[str]) -> Array:
    order = exchanges(positions)
    wrong = np.asarray(order != np.arange(len(trajectory.markers)), dtype=bool)
    if wrong.any():
        names = ", ".join(marker.name for index, marker in enumerate(trajectory.markers) if wrong[:, index].any())
        frames = int(wrong.any(axis=1).sum())
        notes.append(f"{names}: exchanged in {frames} of {len(wrong)} samples; the names were restored")
    return np.asarray(np.take_along_axis(positions, order[:, :, None], axis=1))


def _without_spikes(positions: Array, trajectory: Trajectory, notes: list[str], threshold: float, half_window: int) -> Array:
    found = spikes(positions, threshold, half_window)
    for index, marker in enumerate(trajectory.markers):
        if found[:, index].any():
            notes.append(
                f"{marker.name}: {_of(found[:, index])} samples were removed as spikes (Hampel, {2 * half_window + 1} samples, "
                f"{threshold:g} standard deviations)"
            )
    return np.where(found[:, :, None], np.nan, positions)


def _report_gaps(positions: Array, trajectory: Trajectory, notes: list[str], long_gap: float) -> None:
    missing = np.asarray(np.isnan(positions).any(axis=2), dtype=bool)
    for index, marker in enumerate(trajectory.markers):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], missing[:, index], [False]]).astype(int)))
        longest = int((edges[1::2] - edges[::2]).max(initial=0)) * trajectory.step
        if longest > long_gap and not missing[:, index].all():
            notes.append(f"{marker.name}: {_of(missing[:, index])} samples are missing; the longest gap is {longest:.3g} s")


def _of(flags: NDArray[np.bool_]) -> str:
    return f"{int(flags.sum())} of {len(flags)}"
