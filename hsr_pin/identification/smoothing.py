"""Detection of smoothed tracks from the spectrum of their noise, and the same filter for simulated markers.

Filtered white noise has the squared response of the filter as its spectrum. Segments of the tracks are compared with common
zero-phase filters, by the likelihood of their periodograms (P. Whittle, Ark. Mat. 2, 1953), above the frequencies of the arm's
motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import comb

import numpy as np
from scipy.ndimage import convolve1d
from scipy.special import bdtrc

from hsr_pin.recordings.noise import ORDER
from hsr_pin.trajectory import Array, Dataset

#: Level of the test, over all filters: the probability that white noise is taken for smoothed.
LEVEL = 1e-4
#: Number of samples of a segment, and the lowest frequency that is used [of the sampling rate].
_PIECE, _LOWEST = 64, 0.1
#: Relative noise in the stopband of a filter, due to rounding.
_FLOOR = 1e-4
#: Largest median deviation of the logarithmic noise level between segments: noise is stationary; motion varies far more.
_STEADY = 0.5
#: Largest correlation of the noise of samples that are treated as independent.
_SHARED = 0.05
#: Parameters of the known filters: widths [samples], polynomial degree, orders and cut-off frequencies [of the sampling rate].
_WIDTHS, _DEGREE, _ORDERS, _CUTS = range(3, 23, 2), 2, (2, 4), (0.1, 0.12, 0.14, 0.17, 0.2, 0.24, 0.29, 0.35)
#: Correlation between neighbouring samples of noise that is coloured but not smoothed.
_COLOURS = np.arange(0.0, 1.0, 0.05)
#: Half-width of a computed Butterworth filter [samples], and the weight on both sides that is truncated.
_REACH, _DEAD = 40, 0.005


@dataclass(frozen=True, eq=False)
class Filter:
    """A zero-phase filter.

    Attributes:
        name: a description for messages.
        weights: (2 K + 1,) weights of the samples around each sample.
    """

    name: str
    weights: Array

    @property
    def half(self) -> int:
        """Number of samples on each side of a smoothed sample."""
        return len(self.weights) // 2

    @property
    def spacing(self) -> int:
        """Smallest distance of samples, in samples, at which their noise is independent, also at its multiples."""
        shared = np.abs(_products(self.weights)) / float(self.weights @ self.weights)
        return next(s for s in range(1, len(shared) + 1) if (shared[s::s] <= _SHARED).all())

    @property
    def noise_factor(self) -> float:
        """Factor by which differences of order 4, which assume white noise, underestimate smoothed noise."""
        rough = np.convolve(self.weights, [(-1) ** k * comb(ORDER, k) for k in range(ORDER + 1)])
        return float(np.sqrt(comb(2 * ORDER, ORDER) * (self.weights @ self.weights) / (rough @ rough)))

    def __call__(self, values: Array) -> Array:
        """Return smoothed values (T, ...); beyond the ends, the outermost samples are repeated."""
        return np.asarray(convolve1d(values, self.weights, axis=0, mode="nearest"))


def moving_average(width: int) -> Filter:
    """Return a moving average over an odd number of samples, as in the paper."""
    return Filter(f"a moving average of {width} samples", np.full(width, 1 / width))


def smoothing_of(dataset: Dataset) -> tuple[Filter | None, str]:
    """Return the filter of a dataset's tracks, as declared or as detected from their noise, and a note about it."""
    if dataset.smoothed is not None:
        found, why = moving_average(dataset.smoothed) if dataset.smoothed > 1 else None, "as declared in dataset.toml"
    else:
        found, why = detected(dataset), "as their noise shows (smoothed = 1 in dataset.toml overrides this)"
    if found is None:
        return None, ""
    note = (
        f"the tracks were smoothed by {found.name}, {why}; simulated markers are smoothed in the same way, and one sample in "
        f"{found.spacing} is compared"
    )
    return found, note


def detected(dataset: Dataset) -> Filter | None:
    """Return the filter that smoothed the tracks; None if their noise may be white or coloured otherwise.

    In each segment, the likelihood of the best filter is compared with that of the best first-order autoregression, including
    white noise. If the noise were such an autoregression, the filter would win in less than half of the segments: a sign test of
    level :data:`LEVEL`, corrected for the number of filters. A level that varies between segments indicates motion instead of
    noise.
    """
    powers, tracks = _pieces(dataset)
    if not len(powers):
        return None
    plain = [_likelihoods(powers, spectrum) for spectrum in _spectra_of_colours()]
    base = max(plain, key=lambda each: float(np.median(each)))
    filters, spectra = _filters()
    gains = [_likelihoods(powers, spectrum) - base for spectrum in spectra]
    best = int(np.argmax([np.median(gain) for gain in gains]))
    wins = int((gains[best] > 0).sum())
    if bdtrc(wins - 1, len(powers), 0.5) > LEVEL / len(filters):
        return None
    sizes = np.log((powers / spectra[best]).mean(axis=1))
    deviations = np.concatenate([np.abs(sizes[tracks == k] - np.median(sizes[tracks == k])) for k in np.unique(tracks)])
    return filters[best] if np.median(deviations) < _STEADY else None


def _frequencies() -> Array:
    """Return the frequencies (F,) [of the sampling rate]: every second one of a segment, independent under its window."""
    return np.arange(2, _PIECE // 2 + 1, 2)[np.arange(2, _PIECE // 2 + 1, 2) >= _LOWEST * _PIECE] / _PIECE


def _window() -> Array:
    window = np.hanning(_PIECE + 2)[1:-1]
    return np.asarray(window / np.linalg.norm(window))


def _pieces(dataset: Dataset) -> tuple[Array, Array]:
    """Return periodograms (S, F) of second differences of segments of all coordinates without gaps, and their coordinate (S,)."""
    at = np.round(_frequencies() * _PIECE).astype(int)
    powers, tracks = [np.zeros((0, len(at)))], [np.zeros(0)]
    for trial in dataset.trials:
        rough = np.diff(trial.trajectory.positions.reshape(len(trial.trajectory.time), -1), 2, axis=0)
        for begin in range(0, len(rough) - _PIECE + 1, _PIECE):
            piece = rough[begin : begin + _PIECE]
            power = np.abs(np.fft.rfft(piece * _window()[:, None], axis=0)[at]) ** 2
            seen = np.flatnonzero(np.isfinite(piece).all(axis=0) & (power > 0).all(axis=0))
            powers.append(power[:, seen].T)
            tracks.append(seen.astype(float))
    return np.concatenate(powers), np.concatenate(tracks)


def _likelihoods(powers: Array, spectrum: Array) -> Array:
    """Return the log-likelihoods (S,) of periodograms (S, F) for noise of unknown level with a spectrum (F,)."""
    return np.asarray(-len(spectrum) * np.log((powers / spectrum).mean(axis=1)) - np.log(spectrum).sum())


def _expected(covariance: Array) -> Array:
    """Return the mean periodogram (F,) of second differences of noise with an autocovariance (L,) for lags from 0."""
    padded = np.pad(covariance, (0, _PIECE))
    whole = np.concatenate([padded[:0:-1], padded])
    rough = np.convolve(whole, [1.0, -4.0, 6.0, -4.0, 1.0])[len(padded) + 1 :][:_PIECE]
    lags = np.arange(_PIECE)
    weights = _products(_window()) * np.where(lags == 0, 1.0, 2.0)
    return np.asarray(np.cos(2 * np.pi * np.outer(_frequencies(), lags)) @ (weights * rough))


def _products(weights: Array) -> Array:
    """Return the autocorrelation sums (L,) of weights for lags from 0."""
    return np.asarray(np.correlate(weights, weights, "full")[len(weights) - 1 :])


@lru_cache(maxsize=1)
def _spectra_of_colours() -> list[Array]:
    return [_expected(colour ** np.arange(2.0 * _PIECE)) for colour in _COLOURS]


@lru_cache(maxsize=1)
def _filters() -> tuple[list[Filter], list[Array]]:
    """Return the known filters and the spectrum of white noise after each of them."""
    filters = [moving_average(width) for width in _WIDTHS]
    for width in _WIDTHS[1:]:
        powers = np.vander(np.arange(width) - width // 2, _DEGREE + 1)
        filters.append(Filter(f"a Savitzky-Golay filter of {width} samples", np.linalg.pinv(powers)[-1]))
    for order in _ORDERS:
        for cut in _CUTS:
            ratio = np.tan(np.pi * np.linspace(0, 0.5, 2049)[:-1]) / np.tan(np.pi * cut)
            weights = np.roll(np.fft.irfft(np.append(1 / (1 + ratio ** (2 * order)), 0.0)), _REACH)[: 2 * _REACH + 1]
            dead = int((np.cumsum(np.abs(weights)) < _DEAD).sum())
            weights = weights[dead : len(weights) - dead]
            name = f"a zero-phase Butterworth filter of order {order} with a cut-off near {cut:g} of the sampling rate"
            filters.append(Filter(name, weights / weights.sum()))
    rounding = _FLOOR * _expected(np.eye(1, 3)[0])
    spectra = [_expected(_products(f.weights) / (f.weights @ f.weights)) + rounding for f in filters]
    return filters, spectra
