"""What belongs to the trial and not to the arm: where it rests, how far it was held aside, when it was let go, and how firmly.

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

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.trajectory import Array

#: How well a release is known beyond noise: the pose [share of the length, at the tip], and the instant [samples].
HELD, INSTANT = 0.002, 0.25
#: A hand that lets go slowly does so within the last of these times [s]; what is left of its hold until each of them is known to
#: that share of what holds the bent arm.
LETS_GO, GRIP = (0.02, 0.04, 0.06), (0.5, 0.3, 0.12)
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


def prices(residuals: Sequence[Array], weights: Sequence[Array], lasting: int) -> Array:
    """(K,) By how much dearer than beside white noise each of a trial's own numbers is.

    They are where it rests and how it was held, each in A - 1 directions, when it was let go, and what a hand still held then.

    Those that could stand in for what a model lacks, where a trial rests (the first ``lasting``) and the hold of a hand, stand
    beside the mean of what the model leaves of it, residuals (T, M, A) [m] with weights (T, M, A) [1/m]: its standard error over
    that of white noise of one noise floor (first-order autoregression). From where and when the arm was let go is seen, and
    keeps its price.
    """
    rows = [np.nan_to_num(residual) * weight for residual, weight in zip(residuals, weights, strict=True)]
    count = sum(float((weight > 0).sum()) for weight in weights)
    power = sum(float((row**2).sum()) for row in rows)
    alike = sum(float((row[1:] * row[:-1]).sum()) for row in rows) / max(power, 1e-300)
    rho = float(np.clip(alike, 0.0, _LASTING))
    doubt = np.sqrt(max(1.0, power / max(count, 1.0)) * (1 + rho) / (1 - rho))
    axes = residuals[0].shape[-1]
    own = np.arange(lasting + axes + len(LETS_GO) * (axes - 1))
    return np.where((own < lasting) | (own >= lasting + axes), doubt, 1.0)


def taken_out(residuals: Sequence[Array], weights: Sequence[Array], bases: Sequence[Array], lasting: int) -> list[Array]:
    """For each trial its residual (T, M, A) [m] without what its own numbers explain.

    Where all trials rest elsewhere than they should by the same, the arm is another: where the mean of such a number over the
    trials is more than chance would make it, it stays in the residuals. All releases by one hand may share what the hand does.

    Args:
        residuals: one (T, M, A) [m] per trial; NaN in gaps.
        weights: (T, M, A) [1/m], zero in gaps.
        bases: (T, M, A, K) [m] what one standard deviation of each number makes.
        lasting: how many of the numbers, from the first, say something of the arm where all trials share them.
    """
    seen = lasting + residuals[0].shape[-1]  # those that do not depend on a hand's hold
    if any(basis.shape[-1] > seen for basis in bases):
        price = prices(taken_out(residuals, weights, [basis[..., :seen] for basis in bases], lasting), weights, lasting)
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
    """Whether a trial shows that a hand still held its arm: the evidence for it, Occam's factor and all.

    Args:
        rows: (n,) weighted residuals of the trial, its other numbers taken out.
        hold: (n, H) what one standard deviation of each number of the hold makes of them, priced.
        doubt: by how much less the residuals say than white noise of unit variance would.
    """
    without = Eliminated.of(hold)
    gain = float(rows @ rows - without(rows) @ without(rows)) / doubt**2
    return gain > float(-2 * np.log1p(-without.shrink).sum())


def rest_scatter(rests: Sequence[tuple[object, ArrayLike, ArrayLike]], noise: float) -> float:
    """Standard deviation [m], in each direction, with which an arm comes to rest where it should in every trial.

    Args:
        rests: for each trial the group of those that should rest in one place, the place [m] of the farthest marker across the
            arm, and the bending [m] from which it came: what goes with that is memory of the arm, and no scatter. In space (2,).
        noise: of a place [m].

    Returns:
        0 where it is not clearly more than noise, or nothing repeats.
    """
    squares = freedom = 0.0
    for group in dict.fromkeys(key for key, _, _ in rests):
        places, origins = (
            np.array([np.atleast_1d(each) for each in column])
            for column in zip(*((place, origin) for key, place, origin in rests if key == group), strict=True)
        )
        if len(places) < 3:
            continue
        columns = np.ones((len(places), 1))
        if np.ptp(origins, axis=0).max() > 10 * noise and len(places) > 3 + origins.shape[1]:
            columns = np.column_stack([columns, origins])
        for place in places.T:
            left = place - columns @ np.linalg.lstsq(columns, place, rcond=None)[0]
            squares, freedom = squares + float(left @ left), freedom + len(place) - columns.shape[1]
    variance = squares / freedom - noise**2 if freedom else 0.0
    return float(np.sqrt(variance)) if variance > 8 * noise**2 / np.sqrt(max(freedom, 1.0)) else 0.0
