"""What belongs to a trial and not to the model: how it started, where it rests.

Each is a small number of its own in every trial, about as large as the recordings themselves show (Gaussian prior), and enters
linearly: it is eliminated from the least squares of a fit instead of being fitted (W. J. Browne, D. Draper, A comparison of
Bayesian and likelihood-based methods for fitting multilevel models, Bayesian Anal. 1, 2006: a random effect). What it explains
of a trial is no part of the gap that the laws have to explain.

How dear such a number is beside the residuals depends on what these are. Where a model leaves more than noise, and that lasts,
its many samples say little (:func:`prices`); were they taken for noise, numbers far from any that the prior allows were cheap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.inference.problem import Problem
from hsr_pin.trajectory import Array

#: Standard errors by which the mean of a number over the trials may differ from none by chance.
_CHANCE = 1.5
#: Residuals are never taken for more alike than this from sample to sample.
_LASTING = 0.995


@dataclass(frozen=True, eq=False)
class Eliminated:
    """What residuals or derivatives are without numbers with unit priors: times the inverse root of I + basis basis^T.

    Their squares add up to the least that is left when the K numbers are fitted too, the squares of these added.

    Attributes:
        directions: (n, K) orthonormal.
        shrink: (K,) share of each that is taken away.
    """

    directions: Array
    shrink: Array

    @classmethod
    def of(cls, basis: Array) -> Eliminated:
        """For what one standard deviation of each number makes, (n, K)."""
        u, s, _ = np.linalg.svd(basis, full_matrices=False)
        return cls(u, 1 - 1 / np.sqrt(1 + s**2))

    def __call__(self, rows: Array) -> Array:
        """(n, ...) without them."""
        if not len(self.shrink):
            return rows
        flat = rows.reshape(len(rows), -1)
        return np.asarray((flat - self.directions @ (self.shrink[:, None] * (self.directions.T @ flat))).reshape(rows.shape))

    def after(self, zeros: int, rows: Array) -> Array:
        """(n, C) of rows (n - zeros, C) that follow on so many zeros."""
        out = -self.directions @ (self.shrink[:, None] * (self.directions[zeros:].T @ rows))
        out[zeros:] += rows
        return np.asarray(out)


def prices(residuals: Sequence[Array], weights: Sequence[Array], doubted: NDArray[Any]) -> Array:
    """(K,) By how much dearer than beside white noise each of a trial's own numbers is.

    Those that could stand in for what a model lacks stand beside the mean of what the model leaves of it: its standard error over
    that of white noise of one noise floor (first-order autoregression). The others keep their price.

    Args:
        residuals: for each trial (T, M, A).
        weights: (T, M, A) one over the floor; zero in gaps.
        doubted: (K,) which of the numbers could.
    """
    rows = [np.nan_to_num(residual) * weight for residual, weight in zip(residuals, weights, strict=True)]
    count = sum(float((weight > 0).sum()) for weight in weights)
    power = sum(float((row**2).sum()) for row in rows)
    alike = sum(float((row[1:] * row[:-1]).sum()) for row in rows) / max(power, 1e-300)
    rho = float(np.clip(alike, 0.0, _LASTING))
    doubt = np.sqrt(max(1.0, power / max(count, 1.0)) * (1 + rho) / (1 - rho))
    return np.where(doubted, doubt, 1.0)


def taken_out(residuals: Sequence[Array], weights: Sequence[Array], bases: Sequence[Array], problem: Problem) -> list[Array]:
    """For each trial its residual (T, M, A) without what its own numbers explain.

    Where the mean of a number that says something of the model is, over the trials, more than chance would make it, it stays in
    the residuals: then the model is another.

    Args:
        residuals: one (T, M, A) per trial; NaN in gaps.
        weights: (T, M, A) one over the floor, zero in gaps.
        bases: (T, M, A, K) what one standard deviation of each number makes.
        problem: which of the numbers last, are seen, and could stand in for what the model lacks.
    """
    lasting, seen = problem.lasting, problem.seen
    if any(basis.shape[-1] > seen for basis in bases):
        alone = taken_out(residuals, weights, [basis[..., :seen] for basis in bases], problem)
        price = prices(alone, weights, problem.doubted)
        price[:seen] = 1.0
        bases = [basis / price[: basis.shape[-1]] for basis in bases]
    found = []
    for residual, weight, basis in zip(residuals, weights, bases, strict=True):
        known = weight > 0
        rows, rest = (basis * weight[..., None])[known], (np.nan_to_num(residual) * weight)[known]
        found.append(np.linalg.solve(rows.T @ rows + np.eye(rows.shape[1]), rows.T @ rest))
    shared: dict[bool, Array] = {}
    for released in (False, True):
        own = np.array([numbers[:lasting] for numbers in found if (len(numbers) > lasting) is released])
        if len(own):
            mean, chance = np.median(own, axis=0), _CHANCE / np.sqrt(len(own))
            shared[released] = np.sign(mean) * np.maximum(np.abs(mean) - chance, 0.0)
    return [
        residual - basis @ numbers + basis[..., :lasting] @ shared[len(numbers) > lasting]
        for residual, basis, numbers in zip(residuals, bases, found, strict=True)
    ]


def believed(rows: Array, hold: Array, doubt: float) -> bool:
    """Whether a trial shows some numbers of its own: the evidence for them, Occam's factor and all.

    Args:
        rows: (n,) weighted residuals of the trial, its other numbers taken out.
        hold: (n, H) what one standard deviation of each of them makes of these, priced.
        doubt: by how much less the residuals say than white noise of unit variance would.
    """
    without = Eliminated.of(hold)
    gain = float(rows @ rows - without(rows) @ without(rows)) / doubt**2
    return gain > float(-2 * np.log1p(-without.shrink).sum())
