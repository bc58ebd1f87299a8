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
    def of(cls, rows: Array, basis: Array, groups: Sequence[Array], samples: float) -> Tolerances:
        """Return the elimination, with the variance that the residuals have in each group of channels.

        Args:
            rows: (n,) whitened residuals.
            basis: (n, K) change of the residuals for one standard deviation of each error.
            groups: for each group of channels which residuals belong to it, (n,).
            samples: effective number of independent samples of a group.
        """
        left = rows
        for _ in range(_TURNS):
            weights = np.zeros(len(rows))
            for own in groups:
                weights[own] = samples / own.sum() / max(float(np.mean(left[own] ** 2)), _LEAST) if own.any() else 0.0
            inverse = np.linalg.solve(basis.T @ (basis * weights[:, None]) + np.eye(basis.shape[1]), (basis * weights[:, None]).T)
            left = rows - basis @ (inverse @ rows)
        return cls(basis, inverse, float(np.mean(1 / weights[weights > 0])) ** 0.5)

    def errors(self, rows: Array) -> Array:
        """Return the most probable errors (K,), in standard deviations, for residuals (n,)."""
        return np.asarray(-self.inverse @ rows)

    def __call__(self, rows: Array) -> Array:
        """Return residuals or derivatives (n, ...) without the errors, followed by the K errors with the weight of their prior."""
        errors = self.errors(rows)
        return np.concatenate([rows + np.tensordot(self.basis, errors, 1), self.held * errors])
