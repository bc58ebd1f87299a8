"""Parameters of single trials, such as initial errors and the equilibrium position, which are eliminated from a fit.

Each trial has a few small parameters of its own with a Gaussian prior whose width is estimated from the recordings. They enter
linearly and are eliminated from the least squares instead of being fitted (random effects: W. J. Browne, D. Draper, A comparison
of Bayesian and likelihood-based methods for fitting multilevel models, Bayesian Anal. 1, 2006). The part of a trial that they
explain is not counted as a gap that the laws have to explain.

The prior of a trial parameter has to be compared with the effective noise of the residuals. A model discrepancy is correlated in
time, so that its many samples carry little information (:func:`noise_inflation`). If they were taken as white noise, trial
parameters far outside their prior would be accepted. Errors of initial states are used as far as their squares, over all trials,
agree with their prior (:func:`plausible_inflation`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from hsr_pin.inference.problem import Problem
from hsr_pin.trajectory import Array

#: Number of standard errors by which the mean of a parameter over the trials may differ from zero by chance.
_CHANCE = 1.5
#: Upper limit of the correlation of residuals from one sample to the next.
_LASTING = 0.995
#: Probability with which chance allows the errors of initial states, and number of bisections of a noise inflation.
_PLAUSIBLE, _HALVINGS = 0.99, 30


@dataclass(frozen=True, eq=False)
class Eliminated:
    """Elimination of parameters with unit priors: multiplication by the inverse root of I + basis basis^T.

    The sum of squares of the result is the minimum over the K parameters of the sum of squares plus the squares of the
    parameters.

    Attributes:
        directions: (n, K) orthonormal directions.
        shrink: (K,) share of each direction that is removed.
    """

    directions: Array
    shrink: Array

    @classmethod
    def of(cls, basis: Array) -> Eliminated:
        """Return the elimination for the changes (n, K) that one standard deviation of each parameter causes."""
        u, s, _ = np.linalg.svd(basis, full_matrices=False)
        return cls(u, 1 - 1 / np.sqrt(1 + s**2))

    def __call__(self, rows: Array) -> Array:
        """Return rows (n, ...) with the parameters eliminated."""
        if not len(self.shrink):
            return rows
        flat = rows.reshape(len(rows), -1)
        return np.asarray((flat - self.directions @ (self.shrink[:, None] * (self.directions.T @ flat))).reshape(rows.shape))

    def after(self, zeros: int, rows: Array) -> Array:
        """Return (n, C) for rows (n - zeros, C) that follow the given number of zero rows, with the parameters eliminated."""
        out = -self.directions @ (self.shrink[:, None] * (self.directions[zeros:].T @ rows))
        out[zeros:] += rows
        return np.asarray(out)


def noise_inflation(residuals: Sequence[Array], weights: Sequence[Array], confounded: NDArray[Any]) -> Array:
    """Return the factors (K,) by which the noise exceeds white noise, as seen by each trial parameter.

    For parameters that are confounded with the model discrepancy the factor is the standard error of the mean residual over that
    of white noise of one noise floor (first-order autoregression). For the others it is one.

    Args:
        residuals: for each trial (T, M, A).
        weights: (T, M, A) inverse of the floor; zero in gaps.
        confounded: (K,) whether each parameter is confounded with the model discrepancy.
    """
    rows = [np.nan_to_num(residual) * weight for residual, weight in zip(residuals, weights, strict=True)]
    count = sum(float((weight > 0).sum()) for weight in weights)
    power = sum(float((row**2).sum()) for row in rows)
    correlation = sum(float((row[1:] * row[:-1]).sum()) for row in rows) / max(power, 1e-300)
    rho = float(np.clip(correlation, 0.0, _LASTING))
    ratio = np.sqrt(max(1.0, power / max(count, 1.0)) * (1 + rho) / (1 - rho))
    return np.where(confounded, ratio, 1.0)


def _of_initial_state(problem: Problem) -> NDArray[np.bool_]:
    """Return which trial parameters (K,) are errors of initial states, which every trial has."""
    place = np.arange(len(problem.confounded))
    return np.asarray(problem.confounded & (place >= problem.systematic) & (place < problem.unconditional))


def plausible_inflation(residuals: Sequence[Array], weights: Sequence[Array], bases: Sequence[Array], problem: Problem) -> Array:
    """Return the factors (K,) by which the effective noise exceeds white noise, as seen by errors of initial states.

    It is the smallest common factor with which the sum of squares of the estimated errors of all trials, in units of their
    priors, is no larger than chance allows (discrepancy principle: V. A. Morozov, Methods for Solving Incorrectly Posed Problems,
    1984). Errors of initial states are the confounded parameters that all trials have and that are not systematic; the factor of
    all others is one.

    Args:
        residuals: for each trial (T, M, A); NaN in gaps.
        weights: (T, M, A) inverse of the floor; zero in gaps.
        bases: (T, M, A, K) change for one prior standard deviation of each parameter.
        problem: which parameters are systematic, conditional and confounded.
    """
    limited, factors = np.flatnonzero(_of_initial_state(problem)), np.ones(len(problem.confounded))
    if not len(limited):
        return factors
    sizes, parts = [], []
    for residual, weight, basis in zip(residuals, weights, bases, strict=True):
        known = weight > 0
        u, s, _ = np.linalg.svd((basis[..., limited] * weight[..., None])[known], full_matrices=False)
        sizes.append(s)
        parts.append(u.T @ (np.nan_to_num(residual) * weight)[known])
    size, part = np.concatenate(sizes), np.concatenate(parts)

    def square(factor: float) -> float:
        return float(np.sum((size * part / (size**2 + factor**2)) ** 2))

    allowed = float(chdtri(len(size), 1 - _PLAUSIBLE))
    low, high = 1.0, max(float(np.sqrt(np.abs(size * part).max())), 1.0)  # at the latter no error exceeds its standard deviation
    if square(low) > allowed:
        for _ in range(_HALVINGS):
            middle = np.sqrt(low * high)
            low, high = (middle, high) if square(middle) > allowed else (low, middle)
        factors[limited] = high
    return factors


def trial_inflation(residuals: Sequence[Array], weights: Sequence[Array], bases: Sequence[Array], problem: Problem) -> Array:
    """Return the factors (K,) by which the noise exceeds white noise, as seen by each trial parameter.

    The arguments are those of :func:`without_trial_parameters`.
    """
    reduced = without_trial_parameters(residuals, weights, bases, problem)
    others = noise_inflation(reduced, weights, problem.confounded & ~_of_initial_state(problem))
    return others * plausible_inflation(residuals, weights, bases, problem)


def without_trial_parameters(
    residuals: Sequence[Array], weights: Sequence[Array], bases: Sequence[Array], problem: Problem
) -> list[Array]:
    """Return for each trial its residual (T, M, A) without the part that its trial parameters explain.

    If the mean of a systematic parameter over the trials is larger than chance allows, this mean stays in the residuals, because
    it is an error of the model.

    Args:
        residuals: one (T, M, A) per trial; NaN in gaps.
        weights: (T, M, A) inverse of the floor, zero in gaps.
        bases: (T, M, A, K) change for one prior standard deviation of each parameter.
        problem: which parameters are systematic, conditional and confounded.
    """
    systematic, unconditional = problem.systematic, problem.unconditional
    plausible = plausible_inflation(residuals, weights, bases, problem)
    bases = [basis / plausible[: basis.shape[-1]] for basis in bases]
    if any(basis.shape[-1] > unconditional for basis in bases):
        alone = without_trial_parameters(residuals, weights, [basis[..., :unconditional] for basis in bases], problem)
        inflation = noise_inflation(alone, weights, problem.confounded)
        inflation[:unconditional] = 1.0
        bases = [basis / inflation[: basis.shape[-1]] for basis in bases]
    found = []
    for residual, weight, basis in zip(residuals, weights, bases, strict=True):
        known = weight > 0
        rows, rest = (basis * weight[..., None])[known], (np.nan_to_num(residual) * weight)[known]
        found.append(np.linalg.solve(rows.T @ rows + np.eye(rows.shape[1]), rows.T @ rest))
    shared: dict[bool, Array] = {}
    for released in (False, True):
        own = np.array([numbers[:systematic] for numbers in found if (len(numbers) > systematic) is released])
        if len(own):
            mean, chance = np.median(own, axis=0), _CHANCE / np.sqrt(len(own))
            shared[released] = np.sign(mean) * np.maximum(np.abs(mean) - chance, 0.0)
    return [
        residual - basis @ numbers + basis[..., :systematic] @ shared[len(numbers) > systematic]
        for residual, basis, numbers in zip(residuals, bases, found, strict=True)
    ]


def supported(rows: Array, hold: Array, inflation: float) -> bool:
    """Return whether the evidence, with its Occam factor, supports the conditional parameters of a trial.

    Args:
        rows: (n,) weighted residuals of the trial, with its other parameters eliminated.
        hold: (n, H) change for one prior standard deviation of each conditional parameter, over the noise inflation.
        inflation: factor by which the noise of the residuals exceeds white noise of unit variance.
    """
    without = Eliminated.of(hold)
    gain = float(rows @ rows - without(rows) @ without(rows)) / inflation**2
    return gain > float(-2 * np.log1p(-without.shrink).sum())
