"""Estimates with 95 % intervals, from the variation when one trial at a time is left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from hsr_pin.trajectory import Array

#: Coverage probability of the intervals.
LEVEL = 0.95


class Estimate(NamedTuple):
    """An estimated number with its 95 % interval; by default the interval is unknown."""

    value: float
    low: float = -np.inf
    high: float = np.inf

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0 or self.high < 0


def mean_of(values: Sequence[float] | Array) -> Estimate:
    """Return the mean of independent values with Student's t interval, which is infinite for fewer than two values."""
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    if not len(known):
        return Estimate(np.nan)
    value = float(known.mean())
    if len(known) < 2:
        return Estimate(value)
    reach = float(stdtrit(len(known) - 1, (1 + LEVEL) / 2) * known.std(ddof=1) / np.sqrt(len(known)))
    return Estimate(value, value - reach, value + reach)


def mean_by_trial(values: Sequence[float], trials: Sequence[object]) -> Estimate:
    """Return the mean of values, with a jackknife interval that leaves out one trial at a time."""
    return coefficients_of(np.ones((len(values), 1)), np.array(values), trials)[0]


def coefficients_of(design: Array, values: Array, clusters: Sequence[object]) -> tuple[Estimate, ...]:
    """Return the least-squares coefficients of ``values`` (n,) on ``design`` (n, k), with jackknife intervals.

    One cluster (trial) at a time is left out. If there are hardly more clusters than coefficients, ten consecutive blocks of
    values are left out instead.
    """
    groups = _groups(clusters, design.shape[1] + 2)
    count = int(groups.max()) + 1
    best = np.linalg.lstsq(design, values, rcond=None)[0]
    if count <= design.shape[1]:
        return tuple(Estimate(float(b)) for b in best)
    left = np.array([np.linalg.lstsq(design[groups != g], values[groups != g], rcond=None)[0] for g in range(count)])
    reach = _jackknife(left, design.shape[1])
    return tuple(Estimate(float(b), float(b - r), float(b + r)) for b, r in zip(best, reach, strict=True))


def slope_of(x: Array, values: Array, clusters: Sequence[object]) -> Estimate:
    """Return the slope of ``values`` (n,) over ``x`` (n,), robust to outliers (Theil and Sen), with a jackknife interval."""

    def slope(kept: NDArray[np.bool_]) -> float:
        first, second = np.triu_indices(int(kept.sum()), 1)
        rise, run = (part[kept][second] - part[kept][first] for part in (values, x))
        order = np.argsort(rise / np.where(run == 0, 1e-12, run))  # pairs are weighted by their distance
        weight = np.cumsum(np.abs(run)[order])
        at = order[np.searchsorted(weight, weight[-1] / 2)]
        return float(rise[at] / run[at])

    groups = _groups(clusters, 6)
    best = slope(np.ones(len(values), dtype=bool))
    left = np.array([[slope(groups != g)] for g in range(int(groups.max()) + 1)])
    reach = float(_jackknife(left, 1)[0])
    return Estimate(best, best - reach, best + reach)


def _groups(clusters: Sequence[object], fewest: int) -> NDArray[np.intp]:
    """Return the cluster of each value, or one of at most ten consecutive blocks if there are too few clusters."""
    place = {name: number for number, name in enumerate(dict.fromkeys(clusters))}
    if len(place) >= fewest:
        return np.array([place[name] for name in clusters])
    return np.arange(len(clusters)) * min(10, len(clusters)) // len(clusters)


def _jackknife(left: Array, parameters: int) -> Array:
    """Return the half-widths (k,) of the intervals, from the estimates (g, k) with one group left out each (Tukey 1958)."""
    count = len(left)
    error = np.sqrt((count - 1) / count * ((left - left.mean(axis=0)) ** 2).sum(axis=0))
    return np.asarray(stdtrit(count - parameters, (1 + LEVEL) / 2) * error)
