"""Samples that no arm can have passed through: spikes, and markers exchanged for one another."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from hsr_pin.recordings.noise import MAD_TO_SIGMA, white_noise
from hsr_pin.trajectory import Array

#: A deviation of less than ``threshold`` times this [m] is never called a spike, however quiet the recording.
SMALLEST_SCALE = 1e-4
#: Fewer seen samples than this in a window judge nothing.
FEWEST = 4
#: An exchange must bring the markers this much closer to where they were than leaving them does.
CLEARLY_CLOSER = 0.5
#: So many pairs of markers are compared at once.
_PAIRS = 1 << 18


def spikes(positions: Array, threshold: float = 5.0, half_window: int = 5) -> NDArray[np.bool_]:
    """Find samples that stand far off their neighbours (Hampel's identifier).

    A sample is a spike where a coordinate is farther from the median of its window than ``threshold`` times the larger of the
    window's spread (its median absolute deviation) and the marker's noise: in the window as it is, where the spread is wide if
    the arm moves fast, or in the window without its slope.
    R. K. Pearson, Outliers in process modeling and identification, IEEE Trans. Control Syst. Technol. 10, 2002.

    Args:
        positions: (T, M, 3) [m] evenly sampled; NaN where not seen.
        threshold: in standard deviations.
        half_window: samples on either side.

    Returns:
        (T, M) True at spikes.
    """
    noise = np.fmax(white_noise(positions), SMALLEST_SCALE)
    edge = np.full((half_window, 3), np.nan)
    found = np.zeros(positions.shape[:2], dtype=bool)
    for marker, places in enumerate(positions.swapaxes(0, 1)):  # one by one: windows take eleven times the memory of positions
        windows = sliding_window_view(np.concatenate([edge, places, edge]), 2 * half_window + 1, axis=0)
        judged = np.isfinite(places).all(axis=1) & (np.isfinite(windows).sum(axis=2).min(axis=1) >= FEWEST)
        window, least = windows[judged], noise[marker]  # (J, 3, W)
        found[judged, marker] = _stands_off(window, least, threshold) | _stands_off(_level(window), least, threshold)
    return found


def _stands_off(window: Array, least: Array, threshold: float) -> NDArray[np.bool_]:
    """(J,) whether the middle of a (J, 3, W) window stands off its median in any coordinate."""
    median = np.nanmedian(window, axis=2)
    spread = MAD_TO_SIGMA * np.nanmedian(np.abs(window - median[:, :, None]), axis=2)
    off = np.abs(window[:, :, window.shape[2] // 2] - median) > threshold * np.maximum(spread, least)
    return np.asarray(off.any(axis=1), dtype=bool)


def _level(window: Array) -> Array:
    """(J, 3, W) windows without their slope: the median slope over the pairs of samples that face each other."""
    half = window.shape[2] // 2
    steps = np.arange(1, half + 1)
    slopes = (window[:, :, half + 1 :] - window[:, :, half - 1 :: -1]) / (2 * steps)
    known = np.isfinite(slopes).sum(axis=2, keepdims=True) > half // 2
    slope = np.where(known, np.nanmedian(np.where(known, slopes, 0.0), axis=2, keepdims=True), 0.0)
    return np.asarray(window - slope * np.arange(-half, half + 1))


def exchanges(positions: Array) -> NDArray[np.intp]:
    """Find frames in which the tracking system took markers for one another.

    Markers are followed from frame to frame. Where two or more leap together, each to where another one just was, they have
    changed names, until they leap back. The names that hold for most of the recording are taken for the right ones.

    Args:
        positions: (T, M, 3) [m]; NaN where not seen.

    Returns:
        (T, M) for each frame and marker, the index under which that marker stands; ``arange(M)`` where all is well.
    """
    from scipy.optimize import linear_sum_assignment  # here: half a second that only recordings need

    samples, markers, _ = positions.shape
    order = np.arange(markers)
    orders = np.tile(order, (samples, 1))
    last = _last_seen(positions)
    suspects = set(_leaps_together(last).tolist())
    for frame in range(1, samples):
        if frame in suspects:
            start = max(0, frame - 3)
            before = np.take_along_axis(last[start:frame], orders[start:frame, :, None], axis=1)
            distance = np.minimum(
                *(
                    np.linalg.norm(place[:, None] - last[frame][None], axis=2)
                    for place in (before[-1], np.median(before, axis=0))  # the median, lest a spike came just before
                )
            )
            distance = np.nan_to_num(distance, nan=1.0)  # never seen so far: any place will do
            _, best = linear_sum_assignment(distance)
            stay, go = distance[np.arange(markers), order].sum(), distance[np.arange(markers), best].sum()
            if go < CLEARLY_CLOSER * stay:
                order = best
        orders[frame] = order
    usual = np.array(Counter(map(tuple, orders.tolist())).most_common(1)[0][0])
    return orders[:, np.argsort(usual)]


def _last_seen(positions: Array) -> Array:
    """(T, M, 3) each marker where it was last seen; NaN before it was first seen."""
    seen = np.isfinite(positions).all(axis=2)
    latest = np.maximum.accumulate(np.where(seen, np.arange(len(positions))[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(positions, latest[:, :, None], axis=0))


def _nearest(places: Array) -> Array:
    """(T, M) [m] from each of (T, M, 3) places to the nearest other one in its frame; infinite where there is none."""
    apart = np.linalg.norm(places[:, :, None] - places[:, None], axis=3) + np.diag(np.full(places.shape[1], np.inf))
    return np.asarray(np.nan_to_num(apart, nan=np.inf, posinf=np.inf).min(axis=2))


def _leaps_together(last: Array) -> NDArray[np.intp]:
    """Frames in which two markers or more leap farther than half the way to their nearest neighbour."""
    markers = last.shape[1]
    leap = np.nan_to_num(np.linalg.norm(np.diff(last, axis=0), axis=2))  # (T - 1, M)
    block = max(1, _PAIRS // markers**2)  # frames at a time: all pairs of markers in all frames take more memory than there is
    nearest = np.concatenate([_nearest(last[at : at + block]) for at in range(0, len(last), block)])[:-1]
    return np.flatnonzero((leap > 0.5 * nearest).sum(axis=1) >= 2) + 1
