"""Residuals of a model, and the part of them that is not noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.inference.problem import Prediction, Problem
from hsr_pin.trajectory import Array

#: Lags in samples. White noise has no covariance at them, and an oscillation of any frequency shows at least 0.7 of its power at
#: one of the three.
_LAGS = (1, 2, 3)


def residuals(problem: Problem, predictions: Sequence[Prediction]) -> list[Array]:
    """Return for each run (T, M, A) predicted minus measured; NaN in gaps, the worst value where a simulation failed."""
    return [
        np.where(np.isfinite(run.compared), np.nan_to_num(p.positions - run.compared, nan=problem.worst), np.nan)
        for run, p in zip(problem.runs, predictions, strict=True)
    ]


def rms(residual: Sequence[Array]) -> float:
    """Return the RMS distance over all runs, samples and channels; NaN if there is no measurement."""
    squares = np.concatenate([squared_distance(r) for r in residual])
    return float(np.sqrt(squares.mean())) if len(squares) else float("nan")


def squared_distance(residual: Array) -> Array:
    """Return the squared distance (n,) of every channel at every sample where it was measured."""
    squares = (residual**2).sum(axis=-1).ravel()
    return np.asarray(squares[np.isfinite(squares)])


def lasting_square(residuals: Sequence[Array]) -> float:
    """Return the mean square of the part of residuals that is correlated from sample to sample.

    The squares of the coordinates of a channel are added. The estimate is the covariance of samples a few steps apart. White
    noise of any size does not contribute to it, so that its relative error is about ten times smaller than that of the mean
    square minus an estimated noise floor.

    Args:
        residuals: for each trial (T, M, A), M channels of A coordinates; NaN in gaps.
    """
    return max(abs(_covariance(residuals, lag)) for lag in _LAGS)


def lasting_squares(residuals: Sequence[Array], groups: Sequence[Sequence[int]]) -> Array:
    """Return for each group of channels (G,) the mean square of one coordinate that is correlated from sample to sample.

    Args:
        residuals: for each trial (T, M, A); NaN in gaps.
        groups: for each group the indices of its channels.
    """
    return np.array([lasting_square([each[:, list(own)] for each in residuals]) / residuals[0].shape[-1] for own in groups])


def _covariance(residuals: Sequence[Array], lag: int) -> float:
    """Return the covariance at a lag, from samples between which there are no gaps."""
    total, count = 0.0, 0
    for residual in residuals:
        product = (residual[lag:] * residual[:-lag]).sum(axis=-1)
        there = np.asarray(np.isfinite(residual).all(axis=-1))
        seen = np.logical_and.reduce([there[k : len(there) - lag + k] for k in range(lag + 1)])
        total, count = total + float(product[seen].sum()), count + int(seen.sum())
    return total / count if count else 0.0
