"""Smoothing, differentiation and rank correlation; SciPy has these too, but its modules take longer to load than a whole fit."""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy.ndimage import convolve1d

from hsr_pin.trajectory import Array


def smoothed(values: Array, window: int, degree: int, deriv: int = 0, step: float = 1.0) -> Array:
    """Return values (T, ...), or their time derivative, smoothed by a local polynomial (Savitzky-Golay filter).

    A. Savitzky, M. J. E. Golay, Smoothing and differentiation of data by simplified least squares procedures, Anal. Chem. 36
    (1964). Near the ends, the polynomial through the first or last samples is extended.

    Args:
        values: at least ``window`` values.
        window: odd number of samples.
        degree: degree of the polynomial.
        deriv: order of the derivative.
        step: sampling interval [s].
    """
    half, scale = window // 2, step**deriv
    powers = np.arange(half, -half - 1.0, -1.0) ** np.arange(degree + 1.0)[:, None]
    wanted = np.where(np.arange(degree + 1) == deriv, factorial(deriv) / scale, 0.0)
    out = convolve1d(values, np.linalg.lstsq(powers, wanted, rcond=None)[0], axis=0, mode="constant")
    at = np.arange(float(window))
    for ends, inside in ((slice(None, window), slice(None, half)), (slice(-window, None), slice(-half, None))):
        factors = np.polyfit(at, values[ends].reshape(window, -1), degree)
        for _ in range(deriv):
            factors = factors[:-1] * np.arange(len(factors) - 1.0, 0.0, -1.0)[:, None]
        out[inside] = (np.polyval(factors, at[inside, None]) / scale).reshape(out[inside].shape)
    return np.asarray(out)


def rank_correlation(one: Array, other: Array) -> float:
    """Return Spearman's rank correlation of values (n,) (Am. J. Psychol. 15, 1904); equal values share their mean rank."""
    return float(np.corrcoef(_ranks(one), _ranks(other))[0, 1])


def _ranks(values: Array) -> Array:
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(count)
    return np.asarray((last - (count - 1) / 2)[place])
