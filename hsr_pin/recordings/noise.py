"""How much of a recording is noise, from the recording alone."""

from __future__ import annotations

from math import comb, sqrt

import numpy as np

from hsr_pin.trajectory import Array, Trajectory, Trial

#: Order of the differences taken: motion that is a cubic over five samples leaves no trace in them.
ORDER = 4
#: Fewer differences than this say nothing.
FEWEST = 8
#: Median absolute deviation to standard deviation, for a normal distribution.
MAD_TO_SIGMA = 1.482602218505602


def white_noise(values: Array) -> Array:
    """(...) standard deviation of the white noise in (T, ...) evenly sampled values; NaN where too few follow one another.

    The fourth difference of white noise of unit variance has the variance binom(8, 4) = 70; its median absolute deviation is
    blind to outliers, and smooth motion leaves next to nothing in it (T. Gasser, L. Sroka, C. Jennen-Steinmetz, Residual
    variance and residual pattern in nonlinear regression, Biometrika 73, 1986, with second differences).
    """
    shape = values.shape[1:]
    if len(values) <= ORDER:
        return np.full(shape, np.nan)
    columns = np.abs(np.diff(values, ORDER, axis=0)).reshape(len(values) - ORDER, -1)
    sigma = np.full(columns.shape[1], np.nan)
    for index, column in enumerate(columns.T):
        seen = column[np.isfinite(column)]
        if len(seen) >= FEWEST:
            sigma[index] = MAD_TO_SIGMA * np.median(seen) / sqrt(comb(2 * ORDER, ORDER))
    return sigma.reshape(shape)


def noise_per_axis(recording: Trial | Trajectory) -> Array:
    """(M, 3) [m] standard deviation of the noise in x, y and z of each marker; NaN for a marker that was hardly seen.

    Robust against outliers, gaps and real motion: it comes from fourth differences.
    """
    trajectory = recording.trajectory if isinstance(recording, Trial) else recording
    return white_noise(trajectory.positions)


def noise_floor(recording: Trial | Trajectory) -> Array:
    """(M,) [m] standard deviation of the noise in a coordinate of each marker, its root mean square over x, y and z.

    Noise alone puts a marker sqrt(3) times this (root mean square) from its true place.
    """
    return np.asarray(np.sqrt(np.mean(noise_per_axis(recording) ** 2, axis=1)))
