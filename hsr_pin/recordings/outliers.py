"""Detection of errors of the tracking system: spikes and exchanged markers."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from hsr_pin.recordings.noise import MAD_TO_SIGMA, white_noise
from hsr_pin.trajectory import Array

#: Lower limit of the assumed noise [m]: smaller deviations than ``threshold`` times this are never spikes.
SMALLEST_SCALE = 1e-4
#: Smallest number of seen samples in a window that is evaluated.
FEWEST = 4
#: Factor by which an exchange must reduce the distance of the markers from their previous positions.
CLEARLY_CLOSER = 0.5
#: Number of pairs of markers that are compared at once, which limits the memory.
_PAIRS = 1 << 18


def spikes(positions: Array, threshold: float = 5.0, half_window: int = 5) -> NDArray[np.bool_]:
    """Return which samples are far from their neighbours (Hampel identifier).

    A sample is a spike if a coordinate is farther from the median of its window than ``threshold`` times the larger of the
    window's spread (its median absolute deviation) and the marker's noise. This is tested in the window as it is, where fast
    motion widens the spread, and in the window without its slope.
    R. K. Pearson, Outliers in process modeling and identification, IEEE Trans. Control Syst. Technol. 10, 2002.

    Args:
        positions: (T, M, 3) [m] evenly sampled; NaN where not seen.
        threshold: threshold in standard deviations.
        half_window: number of samples on either side.

    Returns:
        (T, M) mask that is True at spikes.
    """
    noise = np.fmax(white_noise(positions), SMALLEST_SCALE)
    edge = np.full((half_window, 3), np.nan)
    found = np.zeros(positions.shape[:2], dtype=bool)
    for marker, places in enumerate(positions.swapaxes(0, 1)):  # one by one: windows take 11 times the memory
        windows = sliding_window_view(np.concatenate([edge, places, edge]), 2 * half_window + 1, axis=0)
        judged = np.isfinite(places).all(axis=1) & (np.isfinite(windows).sum(axis=2).min(axis=1) >= FEWEST)
        window, least = windows[judged], noise[marker]  # (J, 3, W)
        found[judged, marker] = _is_outlier(window, least, threshold) | _is_outlier(_detrended(window), least, threshold)
    return found


def _is_outlier(window: Array, least: Array, threshold: float) -> NDArray[np.bool_]:
    """Return whether (J,) the middle of each window (J, 3, W) is far from the window's median in any coordinate."""
    median = np.nanmedian(window, axis=2)
    spread = MAD_TO_SIGMA * np.nanmedian(np.abs(window - median[:, :, None]), axis=2)
    off = np.abs(window[:, :, window.shape[2] // 2] - median) > threshold * np.maximum(spread, least)
    return np.asarray(off.any(axis=1), dtype=bool)


def _detrended(window: Array) -> Array:
    """Return windows (J, 3, W) without their slope, the median slope over pairs of samples symmetric about the middle."""
    half = window.shape[2] // 2
    steps = np.arange(1, half + 1)
    slopes = (window[:, :, half + 1 :] - window[:, :, half - 1 :: -1]) / (2 * steps)
    known = np.isfinite(slopes).sum(axis=2, keepdims=True) > half // 2
    slope = np.where(known, np.nanmedian(np.where(known, slopes, 0.0), axis=2, keepdims=True), 0.0)
    return np.asarray(window - slope * np.arange(-half, half + 1))


def exchanges(positions: Array) -> NDArray[np.intp]:
    """Return the order of the markers in each frame, which shows where the tracking system exchanged them.

    Markers are followed from frame to frame. If two or more jump at once, each to the previous position of another, they have
    exchanged names until they jump back. The names that hold for most of the recording are taken as correct.

    Args:
        positions: (T, M, 3) [m]; NaN where not seen.

    Returns:
        (T, M) for each frame and marker, the index under which that marker is recorded; ``arange(M)`` if none are exchanged.
    """
    from scipy.optimize import linear_sum_assignment  # imported here because it takes half a second

    samples, markers, _ = positions.shape
    order = np.arange(markers)
    orders = np.tile(order, (samples, 1))
    last = _last_seen(positions)
    suspects = set(_joint_jumps(last).tolist())
    for frame in range(1, samples):
        if frame in suspects:
            start = max(0, frame - 3)
            before = np.take_along_axis(last[start:frame], orders[start:frame, :, None], axis=1)
            distance = np.minimum(
                *(
                    np.linalg.norm(place[:, None] - last[frame][None], axis=2)
                    for place in (before[-1], np.median(before, axis=0))  # the median, in case the last position was a spike
                )
            )
            distance = np.nan_to_num(distance, nan=1.0)  # never seen so far, so that any position matches
            _, best = linear_sum_assignment(distance)
            stay, go = distance[np.arange(markers), order].sum(), distance[np.arange(markers), best].sum()
            if go < CLEARLY_CLOSER * stay:
                order = best
        orders[frame] = order
    usual = np.array(Counter(map(tuple, orders.tolist())).most_common(1)[0][0])
    return orders[:, np.argsort(usual)]


def _last_seen(positions: Array) -> Array:
    """Return the last seen position (T, M, 3) [m] of each marker; NaN before it was first seen."""
    seen = np.isfinite(positions).all(axis=2)
    latest = np.maximum.accumulate(np.where(seen, np.arange(len(positions))[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(positions, latest[:, :, None], axis=0))


def _nearest(places: Array) -> Array:
    """Return the distance (T, M) [m] from each position (T, M, 3) to the nearest other one in its frame; infinite if none."""
    apart = np.linalg.norm(places[:, :, None] - places[:, None], axis=3) + np.diag(np.full(places.shape[1], np.inf))
    return np.asarray(np.nan_to_num(apart, nan=np.inf, posinf=np.inf).min(axis=2))


def _joint_jumps(last: Array) -> NDArray[np.intp]:
    """Return the frames in which two or more markers jump farther than half the distance to their nearest neighbour."""
    markers = last.shape[1]
    jump = np.nan_to_num(np.linalg.norm(np.diff(last, axis=0), axis=2))  # (T - 1, M)
    block = max(1, _PAIRS // markers**2)  # frames at a time, as all pairs of markers in all frames would not fit into memory
    nearest = np.concatenate([_nearest(last[at : at + block]) for at in range(0, len(last), block)])[:-1]
    return np.flatnonzero((jump > 0.5 * nearest).sum(axis=1) >= 2) + 1
