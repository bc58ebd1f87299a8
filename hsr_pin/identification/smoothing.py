"""Smoothed tracks: found from the colour of their noise, and what the same filter makes of noise and of simulated markers.

White noise that was filtered has the filter's squared response for a spectrum. Pieces of the tracks are compared with those of
usual filters that shift nothing in time, by the likelihood of their periodograms (P. Whittle, Ark. Mat. 2, 1953), above the
frequencies at which arms move.
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

#: Level of the test, over all filters: with which probability white noise is taken for smoothed.
LEVEL = 1e-4
#: Samples of a piece, and the lowest frequency that is looked at [of the sampling rate].
_PIECE, _LOWEST = 64, 0.1
#: What is left of white noise where a filter lets nothing pass: rounding.
_FLOOR = 1e-4
#: Noise is as large in one piece as in another: its logarithm differs by no more (median); motion differs by far more.
_STEADY = 0.5
#: Samples so far apart that they share no more than this of their noise are taken for independent.
_SHARED = 0.05
#: Of the filters that are known: widths [samples], degree of the polynomials, orders and cut-off frequencies [of the rate].
_WIDTHS, _DEGREE, _ORDERS, _CUTS = range(3, 23, 2), 2, (2, 4), (0.1, 0.12, 0.14, 0.17, 0.2, 0.24, 0.29, 0.35)
#: Correlation from sample to sample of noise that is coloured and not smoothed.
_COLOURS = np.arange(0.0, 1.0, 0.05)
#: Samples on either side that a Butterworth filter is computed for, and the weight on either side that is taken for none.
_REACH, _DEAD = 40, 0.005


@dataclass(frozen=True, eq=False)
class Filter:
    """A filter that shifts nothing in time.

    Attributes:
        name: as a person would say it.
        weights: (2 K + 1,) of the samples around each.
    """

    name: str
    weights: Array

    @property
    def half(self) -> int:
        """Samples on either side of the one that is smoothed."""
        return len(self.weights) // 2

    @property
    def spacing(self) -> int:
        """Samples so far apart, or a multiple of that, have independent noise."""
        shared = np.abs(_products(self.weights)) / float(self.weights @ self.weights)
        return next(s for s in range(1, len(shared) + 1) if (shared[s::s] <= _SHARED).all())

    @property
    def undervalued(self) -> float:
        """How much larger smoothed noise is than the differences of order 4 of its samples tell of white noise."""
        rough = np.convolve(self.weights, [(-1) ** k * comb(ORDER, k) for k in range(ORDER + 1)])
        return float(np.sqrt(comb(2 * ORDER, ORDER) * (self.weights @ self.weights) / (rough @ rough)))

    def __call__(self, values: Array) -> Array:
        """(T, ...) smoothed; beyond the ends the outermost samples go on."""
        return np.asarray(convolve1d(values, self.weights, axis=0, mode="nearest"))


def moving_average(width: int) -> Filter:
    """The mean over an odd number of samples, as in the paper."""
    return Filter(f"a moving average of {width} samples", np.full(width, 1 / width))


def smoothing_of(dataset: Dataset) -> tuple[Filter | None, str]:
    """The filter that the tracks of a dataset went through, as declared or as their noise shows, and a note on it."""
    if dataset.smoothed is not None:
        found, why = moving_average(dataset.smoothed) if dataset.smoothed > 1 else None, "as dataset.toml says"
    else:
        found, why = detected(dataset), "as their noise shows (smoothed = 1 in dataset.toml says otherwise)"
    if found is None:
        return None, ""
    note = (
        f"the tracks were smoothed by {found.name}, {why}: simulated markers are smoothed alike, and one sample in "
        f"{found.spacing} is compared"
    )
    return found, note


def detected(dataset: Dataset) -> Filter | None:
    """The filter that smoothed the tracks; None where their noise may be white, or coloured otherwise.

    In each piece the likelihood of the best filter is compared with that of the best first-order autoregression, white noise
    among them. Were the noise such, the filter would win in less than half of the pieces: a sign test of level :data:`LEVEL`,
    over the number of filters. What is not as large in all pieces is motion, and no noise.
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
    apart = np.concatenate([np.abs(sizes[tracks == k] - np.median(sizes[tracks == k])) for k in np.unique(tracks)])
    return filters[best] if np.median(apart) < _STEADY else None


def _frequencies() -> Array:
    """(F,) [of the sampling rate] every other one of a piece: those between are not independent under its window."""
    return np.arange(2, _PIECE // 2 + 1, 2)[np.arange(2, _PIECE // 2 + 1, 2) >= _LOWEST * _PIECE] / _PIECE


def _window() -> Array:
    window = np.hanning(_PIECE + 2)[1:-1]
    return np.asarray(window / np.linalg.norm(window))


def _pieces(dataset: Dataset) -> tuple[Array, Array]:
    """(S, F) periodograms of the second differences of pieces of all coordinates without gaps, and (S,) of which each is."""
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
    """(S,) logarithms, of periodograms (S, F) of noise with a spectrum (F,) of any size."""
    return np.asarray(-len(spectrum) * np.log((powers / spectrum).mean(axis=1)) - np.log(spectrum).sum())


def _expected(covariance: Array) -> Array:
    """(F,) mean periodogram of a piece of second differences of noise, of which (L,) is the covariance, lags from 0 on."""
    padded = np.pad(covariance, (0, _PIECE))
    whole = np.concatenate([padded[:0:-1], padded])
    rough = np.convolve(whole, [1.0, -4.0, 6.0, -4.0, 1.0])[len(padded) + 1 :][:_PIECE]
    lags = np.arange(_PIECE)
    weights = _products(_window()) * np.where(lags == 0, 1.0, 2.0)
    return np.asarray(np.cos(2 * np.pi * np.outer(_frequencies(), lags)) @ (weights * rough))


def _products(weights: Array) -> Array:
    """(L,) sums of the products of weights so many places apart, from 0 on."""
    return np.asarray(np.correlate(weights, weights, "full")[len(weights) - 1 :])


@lru_cache(maxsize=1)
def _spectra_of_colours() -> list[Array]:
    return [_expected(colour ** np.arange(2.0 * _PIECE)) for colour in _COLOURS]


@lru_cache(maxsize=1)
def _filters() -> tuple[list[Filter], list[Array]]:
    """The filters that are known, and what each makes of white noise."""
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
            name = f"a Butterworth filter of order {order}, forth and back, about {cut:g} of the sampling rate"
            filters.append(Filter(name, weights / weights.sum()))
    rounding = _FLOOR * _expected(np.eye(1, 3)[0])
    spectra = [_expected(_products(f.weights) / (f.weights @ f.weights)) + rounding for f in filters]
    return filters, spectra
