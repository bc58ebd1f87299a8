"""Estimation of the measurement noise of a recording from the recording alone."""

from __future__ import annotations

from math import comb, sqrt

import numpy as np

from hsr_pin.trajectory import Array, Trajectory, Trial

#: Order of the differences, which vanish for motion that is a cubic polynomial over five samples.
ORDER = 4
#: Smallest number of differences from which noise is estimated.
FEWEST = 8
#: Ratio of standard deviation to median absolute deviation of a normal distribution.
MAD_TO_SIGMA = 1.482602218505602


def white_noise(values: Array) -> Array:
    """Return the standard deviation (...) of the white noise in evenly sampled values (T, ...); NaN if there are too few.

    The fourth difference of white noise of unit variance has the variance binom(8, 4) = 70. Its median absolute deviation is
    insensitive to outliers and to smooth motion (T. Gasser, L. Sroka, C. Jennen-Steinmetz, Residual
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
    """Return the standard deviation (M, 3) [m] of the noise in x, y and z of each marker; NaN for a marker rarely seen.

    The estimate comes from fourth differences and is robust against outliers, gaps and real motion.
    """
    trajectory = recording.trajectory if isinstance(recording, Trial) else recording
    return white_noise(trajectory.positions)


def noise_floor(recording: Trial | Trajectory) -> Array:
    """Return the noise (M,) [m] in a coordinate of each marker: the RMS over x, y and z of its standard deviations.

    The RMS distance of a marker from its true position is sqrt(3) times this.
    """
    return np.asarray(np.sqrt(np.mean(noise_per_axis(recording) ** 2, axis=1)))
