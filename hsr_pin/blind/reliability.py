"""Reliability of stated confidences: how often claims were right.

The reliability diagram and the expected calibration error: A. H. Murphy, R. L. Winkler, Reliability of Subjective Probability
Forecasts of Precipitation and Temperature, Appl. Statist. 26, 1977; M. P. Naeini et al., Obtaining Well Calibrated Probabilities
Using Bayesian Binning, AAAI 2015. The claims of one case are correlated, so cases are resampled, not claims (A. C. Davison,
D. V. Hinkley, Bootstrap Methods and their Application, 1997, ch. 3). A small number of claims scatters about perfect calibration;
therefore the error of a perfectly calibrated source with the same claims is reported as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.blind.rate import Rate

#: Number of bins of equal width.
BINS = 10
RESAMPLES = 2000


@dataclass(frozen=True)
class Bin:
    """Claims whose confidence lies between `low` and `high`.

    Attributes:
        low, high: edges of the bin.
        stated: mean confidence of the claims.
        right: rate of right claims.
    """

    low: float
    high: float
    stated: float
    right: Rate


@dataclass(frozen=True)
class Reliability:
    """Reliability of all claims.

    Attributes:
        bins: bins with at least one claim.
        error: expected calibration error, the mean distance between stated and true rate over the claims.
        interval: its 95 % interval over cases.
        by_chance: its mean and its 95 % quantile if every confidence were right.
    """

    bins: tuple[Bin, ...]
    error: float
    interval: tuple[float, float]
    by_chance: tuple[float, float]

    def document(self) -> dict[str, Any]:
        """Return the reliability as a JSON document."""
        return {
            "error": self.error,
            "ci95": list(self.interval),
            "by_chance": {"mean": self.by_chance[0], "q95": self.by_chance[1]},
            "bins": [
                {"low": each.low, "high": each.high, "stated": each.stated, "right": each.right.hits, "of": each.right.of}
                for each in self.bins
            ],
        }


def reliability(cases: Sequence[Sequence[tuple[float, bool]]], seed: int = 0) -> Reliability:
    """Return the reliability for the claims of each case, pairs of confidence (0 to 1) and truth; at least one claim."""
    owner = np.repeat(np.arange(len(cases)), [len(claims) for claims in cases])
    stated = np.array([value for claims in cases for value, _ in claims], dtype=float)
    true = np.array([so for claims in cases for _, so in claims], dtype=float)
    place = np.minimum((stated * BINS).astype(int), BINS - 1)
    rng = np.random.default_rng(seed)
    draws = rng.multinomial(len(cases), np.full(len(cases), 1 / len(cases)), RESAMPLES)
    resampled = [_error(place, stated - true, times[owner]) for times in draws if times[owner].any()]
    once = np.ones(stated.size)
    chance = [_error(place, stated - (rng.random(stated.size) < stated), once) for _ in range(RESAMPLES)]
    low, high = np.quantile(resampled, (0.025, 0.975))
    bins = tuple(
        Bin(k / BINS, (k + 1) / BINS, float(stated[inside].mean()), Rate(int(true[inside].sum()), int(inside.sum())))
        for k in range(BINS)
        if (inside := place == k).any()
    )
    error = _error(place, stated - true, once)
    return Reliability(bins, error, (float(low), float(high)), (float(np.mean(chance)), float(np.quantile(chance, 0.95))))


def _error(place: NDArray[np.int64], excess: NDArray[np.float64], times: NDArray[np.float64]) -> float:
    """Return the calibration error from the bin of each claim, its confidence minus its truth, and its multiplicity."""
    sums = np.bincount(place, weights=excess * times, minlength=BINS)
    return float(np.abs(sums).sum() / times.sum())
