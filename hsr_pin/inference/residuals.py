"""How far a model is from recordings, and what of that is no noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.inference.problem import Prediction, Problem
from hsr_pin.trajectory import Array

#: Samples apart: white noise has no covariance over them, and whatever swings, at any frequency, shows seven tenths of its power
#: in one of the three.
_LAGS = (1, 2, 3)


def residuals(problem: Problem, predictions: Sequence[Prediction]) -> list[Array]:
    """For each run (T, M, A) predicted minus measured; NaN in gaps, the worst there is where a simulation failed."""
    return [
        np.where(np.isfinite(run.compared), np.nan_to_num(p.positions - run.compared, nan=problem.worst), np.nan)
        for run, p in zip(problem.runs, predictions, strict=True)
    ]


def rms(residual: Sequence[Array]) -> float:
    """RMS distance over all runs, samples and channels; NaN where none was seen."""
    squares = np.concatenate([squared_distance(r) for r in residual])
    return float(np.sqrt(squares.mean())) if len(squares) else float("nan")


def squared_distance(residual: Array) -> Array:
    """(n,) of every channel at every sample at which it was seen."""
    squares = (residual**2).sum(axis=-1).ravel()
    return np.asarray(squares[np.isfinite(squares)])


def lasting_square(residuals: Sequence[Array]) -> float:
    """Mean square of the part of residuals that lasts from one sample to the next; in space of a distance, over its coordinates.

    It is the covariance of samples a few steps apart: white noise drops out of it by itself, whatever its size, so that it is
    known ten times better than the mean square beyond an estimated noise floor.

    Args:
        residuals: for each trial (T, M, A), M channels of A coordinates; NaN in gaps.
    """
    return max(abs(_covariance(residuals, lag)) for lag in _LAGS)


def _covariance(residuals: Sequence[Array], lag: int) -> float:
    """Of samples so far apart, where those between them were seen too."""
    total, count = 0.0, 0
    for residual in residuals:
        product = (residual[lag:] * residual[:-lag]).sum(axis=-1)
        there = np.asarray(np.isfinite(residual).all(axis=-1))
        seen = np.logical_and.reduce([there[k : len(there) - lag + k] for k in range(lag + 1)])
        total, count = total + float(product[seen].sum()), count + int(seen.sum())
    return total / count if count else 0.0
