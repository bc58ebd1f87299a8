"""Errors of declared numbers within their tolerances, which are eliminated from a fit.

A model contains numbers that are known with a standard deviation only, such as masses. Their errors are the same in all trials.
They enter linearly, with a Gaussian prior, and are eliminated from the least squares: the part of the residuals that they explain
is not counted as a gap that the laws have to explain. Their prior is compared with the coarsened likelihood of
:mod:`hsr_pin.inference.evidence`, in which N correlated residuals of a group of channels count as nu independent ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.trajectory import Array

#: Number of times that the variance of the residuals and the errors are estimated in turn.
_TURNS = 5
#: Smallest mean square of whitened residuals, in squared floors; no model is more exact than its floor.
_LEAST = 1.0


@dataclass(frozen=True, eq=False)
class Tolerances:
    """Elimination of K errors with unit priors from whitened residuals (n,).

    Attributes:
        basis: (n, K) change of the residuals for one standard deviation of each error.
        inverse: (K, n) matrix whose product with the residuals is minus the most probable errors.
        held: weight of the prior relative to that of a residual.
    """

    basis: Array
    inverse: Array
    held: float

    @classmethod
    def of(cls, rows: Array, basis: Array, groups: Sequence[NDArray[np.bool_]], samples: float) -> Tolerances:
        """Return the elimination, with the variance that the residuals have in each group of channels.

        Args:
            rows: (n,) whitened residuals.
            basis: (n, K) change of the residuals for one standard deviation of each error.
            groups: for each group of channels which residuals belong to it, (n,).
            samples: effective number of independent samples of a group.
        """
        parts = [(rows[own], basis[own]) for own in groups if own.any()]
        sums = [(len(r), float(r @ r), b.T @ r, b.T @ b) for r, b in parts]
        errors: Array = np.zeros(basis.shape[1])
        for _ in range(_TURNS):
            left = [max(float(rr + 2 * errors @ br + errors @ bb @ errors) / n, _LEAST) for n, rr, br, bb in sums]
            weights = [samples / n / square for (n, *_), square in zip(sums, left, strict=True)]
            normal = np.eye(len(errors)) + sum(w * bb for w, (*_, bb) in zip(weights, sums, strict=True))
            right = sum(w * br for w, (_, _, br, _) in zip(weights, sums, strict=True))
            errors = np.asarray(-np.linalg.solve(normal, right))
        each = np.zeros(len(rows))
        for own, weight in zip((own for own in groups if own.any()), weights, strict=True):
            each[own] = weight
        inverse = np.asarray(np.linalg.solve(normal, (basis * each[:, None]).T))
        return cls(basis, inverse, float(np.mean(1 / each[each > 0])) ** 0.5)

    def errors(self, rows: Array) -> Array:
        """Return the most probable errors (K,), in standard deviations, for residuals (n,)."""
        return np.asarray(-self.inverse @ rows)

    def __call__(self, rows: Array) -> Array:
        """Return residuals or derivatives (n, ...) without the errors, followed by the K errors weighted by their prior."""
        errors = self.errors(rows)
        return np.concatenate([rows + np.tensordot(self.basis, errors, 1), self.held * errors])
