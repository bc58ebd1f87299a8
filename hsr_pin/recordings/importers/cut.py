"""Division of one long recording into trials: at given times, or where the arm rests under a constant input.

A simulation starts in equilibrium, so a trial should begin at rest. An arm rests while every marker stays within its noise, or a
hundredth of the range of its motion, and the input is constant.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from hsr_pin.errors import InputError
from hsr_pin.recordings.importers.settings import AUTO
from hsr_pin.recordings.noise import white_noise
from hsr_pin.trajectory import INPUTS, Array, Trajectory

#: Shortest rest between two trials, and the part of it with which the next trial begins [s].
_REST, _BEFORE = 0.5, 0.25
#: Largest range of a marker at rest, in standard deviations of its noise, and of any signal, as a share of its whole range.
_NOISE, _SHARE = 8.0, 0.01


def cut(trajectory: Trajectory, times: Sequence[float] | str, path: Path) -> list[Trajectory]:
    """Return the trials in a recording, each with times from 0 on; a single motion from rest is one trial.

    Args:
        trajectory: the recording.
        times: times [s] at which new trials begin, or "auto": shortly before each motion that follows a rest.
        path: file of the recording, for errors.

    Raises:
        InputError: a time is outside the recording, or the arm never rests.
    """
    time = trajectory.time
    if isinstance(times, str):
        still = _still(trajectory)
        begins = _after_rests(still, trajectory.step)
        if not still.any():
            expected = f"rests of {_REST:g} s or more between motions, under a constant input"
            raise InputError("cut", expected=expected, received="none", hint="give the times with --cut T,T,...", file=path)
    else:
        outside = [each for each in times if not time[0] < each < time[-1]]
        if outside:
            received = ", ".join(f"{each:g}" for each in outside)
            raise InputError("cut", expected=f"times between {time[0]:g} and {time[-1]:g} s", received=received, file=path)
        begins = [int(np.searchsorted(time, each - 1e-9)) for each in sorted(set(times))]
    edges = [0, *begins, len(time)]
    return [_part(trajectory, first, last) for first, last in itertools.pairwise(edges) if last - first > 1]


def parse_cut(text: str) -> tuple[float, ...] | str:
    """Return times [s] from a text such as ``12.5,30``, or "auto".

    Raises:
        ValueError: the text is neither.
    """
    return AUTO if text == AUTO else tuple(float(part) for part in text.split(","))


def _part(trajectory: Trajectory, first: int, last: int) -> Trajectory:
    """Return the samples ``first`` to ``last`` (exclusive) of a recording."""
    rows, begin, end = slice(first, last), trajectory.time[first], trajectory.time[last - 1]

    return replace(
        trajectory,
        time=trajectory.time[rows] - begin,
        positions=trajectory.positions[rows],
        notes=(*trajectory.notes, f"cut from {begin:g} to {end:g} s of the recording"),
        **{name: values[rows] for name in INPUTS if (values := getattr(trajectory, name)) is not None},
    )


def _after_rests(still: NDArray[np.bool_], step: float) -> list[int]:
    """Return the samples shortly before each motion that follows a rest and an earlier motion, for samples every ``step`` [s]."""
    changes = np.flatnonzero(np.diff(still.astype(int)))
    ends = [int(k) + 1 for k in changes if still[k]]  # the arm begins to move
    before = round(_BEFORE / step)
    return [end - before for end in ends if not still[: end - before].all()]


def _still(trajectory: Trajectory) -> NDArray[np.bool_]:
    """Return for each sample whether it belongs to a rest."""
    samples = len(trajectory.time)
    window = max(3, round(_REST / trajectory.step))
    tracks = trajectory.positions.reshape(samples, -1)
    allowed = np.maximum(_NOISE * np.nan_to_num(white_noise(tracks)), _SHARE * _largest_range(trajectory.positions))
    signals = [(tracks, allowed)]
    for name in INPUTS:
        if (values := getattr(trajectory, name)) is not None:
            columns = np.stack([_filled(column) for column in values.reshape(samples, -1).T], axis=1)
            signals.append((columns, _SHARE * np.ptp(columns, axis=0)))
    quiet = np.ones(samples, dtype=bool)
    for columns, limit in signals:
        for column, most in zip(columns.T, np.broadcast_to(limit, columns.shape[1]), strict=True):
            filled = _filled(column)
            spread = maximum_filter1d(filled, window, mode="nearest") - minimum_filter1d(filled, window, mode="nearest")
            quiet &= spread <= most
    return np.asarray(maximum_filter1d(quiet.astype(np.uint8), window, mode="constant") > 0)  # the whole window is at rest


def _largest_range(positions: Array) -> float:
    """Return the range [m] of the coordinate that moves most, of markers (T, M, 3)."""
    seen = positions.reshape(len(positions), -1)
    spans = [np.ptp(column[np.isfinite(column)]) for column in seen.T if np.isfinite(column).any()]
    return float(max(spans, default=0.0))


def _filled(column: Array) -> Array:
    """Return values (T,) with gaps interpolated linearly; zeros if there are none at all."""
    seen = np.isfinite(column)
    rows = np.arange(len(column))
    return np.interp(rows, rows[seen], column[seen]) if seen.any() else np.zeros(len(column))
