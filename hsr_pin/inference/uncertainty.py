"""Uncertainty of a fit: intervals, correlations, and parameter combinations that the data do not determine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from hsr_pin.inference.fit import Fit
from hsr_pin.trajectory import Array

#: Directions whose singular value is below this share of the largest one count as undetermined (scaled parameters).
WEAK = 1e-3
#: Lower limits of the singular values: relative to the largest one (accuracy of finite differences), and absolute.
_BLIND, _NOTHING = 1e-8, 1e-100
#: Assumed least size of a constant model error, as a share of the floor of one sample.
_LASTING = 0.01


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Uncertainty of the values of a fit.

    Attributes:
        standard_error: (P,) in the parameters' units.
        interval: (P, 2) 95 % intervals, within the bounds.
        correlation: (P, P) correlations of the estimates.
        inflation: (P,) variance inflation: the ratio of the variance to its value for independent residuals.
        condition: ratio of the largest to the smallest singular value of the scaled derivatives, at most 1e8.
        weak: descriptions of parameter combinations that the data do not determine: their singular value is below a thousandth of
            the largest one, or their 95 % interval is wider than the parameters' scale in both directions.
    """

    standard_error: Array
    interval: Array
    correlation: Array
    inflation: Array
    condition: float
    weak: tuple[str, ...]


def uncertainty(fit: Fit) -> Uncertainty:
    """Return intervals from the derivatives at the optimum, for residuals that are correlated in time.

    The covariance is the sandwich estimate H^-1 S H^-1, where S is the long-run covariance of the scores g_t = J_t^T r_t by Newey
    and West (Econometrica 55, 1987): a model error that lasts for many samples counts as few independent observations. The
    variance is never smaller than that for white noise of the same size, nor than that for a constant error of one hundredth of
    the floor, because no chain of links is more exact than that.
    """
    facts = fit.hypothesis.parameters
    scale = np.array([fact.scale for fact in facts])
    hessian, middle = np.zeros((len(scale), len(scale))), np.zeros((len(scale), len(scale)))
    squares = count = 0.0
    for run, (raw_residuals, slopes, weights) in enumerate(zip(fit.raw_residuals, fit.slopes, fit.weights, strict=True)):
        weighted, r = slopes * weights[..., None] * scale, np.nan_to_num(raw_residuals) * weights
        mask = weights > 0
        without = fit.eliminated(run)
        weighted[mask], r[mask] = without(weighted[mask]), without(r[mask])
        hessian += np.einsum("tmcp,tmcq->pq", weighted, weighted)
        middle += _long_run(np.einsum("tmcp,tmc->tp", weighted, r), _memory(r))
        squares, count = squares + float((r**2).sum()), count + float((weights > 0).sum())
    singular_values, directions = _spectrum(hessian)
    inverse = directions / singular_values**2 @ directions.T
    freedom = max(count - len(scale), 1.0)
    white = inverse * squares / freedom
    robust = inverse @ middle @ inverse
    lasting = inverse * count * _LASTING**2
    variance = np.maximum(np.maximum(np.diag(robust), np.diag(white)), np.diag(lasting))
    standard, quantile = np.sqrt(variance), stdtrit(freedom, 0.975)
    bounds = np.array([(fact.lower, fact.upper) for fact in facts])
    reach = (quantile * standard * scale)[:, None] * np.array([-1.0, 1.0])
    size = np.sqrt(np.diag(white))
    inflation = variance / np.diag(white)
    widths = quantile * np.sqrt(squares / freedom * inflation.max()) / singular_values
    return Uncertainty(
        standard_error=standard * scale,
        interval=np.clip(fit.values[:, None] + reach, bounds[:, :1], bounds[:, 1:]),
        correlation=white / np.outer(size, size),
        inflation=inflation,
        condition=float(singular_values[0] / singular_values[-1]) if hessian.any() else 1 / _BLIND,
        weak=tuple(
            _in_words(direction, [fact.name for fact in facts])
            for value, width, direction in zip(singular_values, widths, directions.T, strict=True)
            if value < WEAK * singular_values[0] or width > 1
        ),
    )


def _memory(residual: Array) -> int:
    """Return the lag [samples] after which the residuals (T, M, 3) are no longer correlated."""
    centred = residual.reshape(len(residual), -1)
    power = float((centred**2).sum())
    longest = max(1, len(centred) // 4)
    for lag in range(1, longest):
        if float((centred[lag:] * centred[:-lag]).sum()) < 0.1 * power:
            return lag
    return longest


def _long_run(scores: Array, lags: int) -> Array:
    """Return the long-run covariance of scores with Bartlett weights up to a number of lags."""
    total = scores.T @ scores
    for lag in range(1, lags):
        weight = 1 - lag / lags  # Bartlett kernel
        cross = scores[lag:].T @ scores[:-lag]
        total = total + weight * (cross + cross.T)
    return np.asarray(total)


def _spectrum(hessian: Array) -> tuple[Array, Array]:
    """Return the singular values (P,) of the derivatives, the largest first, and their directions (P, P) as columns."""
    values, directions = np.linalg.eigh(hessian)
    singular_values = np.sqrt(np.maximum(values[::-1], 0.0))
    return np.maximum(singular_values, max(_BLIND * singular_values[0], _NOTHING)), directions[:, ::-1]


def _in_words(direction: Array, names: list[str]) -> str:
    """Return the description of a weakly determined direction in parameter space."""
    order = np.argsort(-np.abs(direction))
    parts = [names[i] for i in order if abs(direction[i]) > 0.3]
    signs = {bool(direction[i] > 0) for i in order[: len(parts)]}
    if len(parts) == 1:
        return f"{parts[0]} is hardly determined by these data"
    return (
        f"{' and '.join(parts)} can change {'together' if len(signs) == 1 else 'in opposite directions'} without visible effect"
    )
