"""Uncertainty of the pressure map: a multivariate regression of two responses on a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class PressureUncertainty:
    """Standard deviations of stiffness, bending and torque at given pressures, each of shape (...).

    ``_mean``: of the plane itself, which more measurements would reduce. ``_single``: of one more measurement about the plane
    (plane and scatter together), as expected for the next arm or run.

    Attributes:
        keq_mean, keq_single: stiffness [Nm/rad]; zero if the stiffness was given.
        phi_mean, phi_single: bending angle [rad].
        tau_mean, tau_single: torque [N m], to first order in both, with their correlation.
        extrapolates: whether the pressures are outside the convex hull of the measured ones.
    """

    keq_mean: Array
    keq_single: Array
    phi_mean: Array
    phi_single: Array
    tau_mean: Array
    tau_single: Array
    extrapolates: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Scatter:
    """Least-squares planes of stiffness and bending over the same pressures (multivariate linear regression).

    With regressors x = (1, P1, P2), leverage h = x' (X'X)^-1 x and residual covariance S (n - 3 degrees of freedom), the plane
    has covariance h S and one more measurement (1 + h) S: Seber and Lee, Linear Regression Analysis, 2nd ed. 2003, Ch. 5.

    Attributes:
        pressures: (n, 2) measured pressures [bar].
        planes: (3, 2) coefficients of 1, P1, P2 for stiffness and bending.
        spread: (3, 3) (X'X)^-1; multiplied by an element of ``residual_covariance`` it is the covariance of a plane's
            coefficients.
        residual_covariance: (2, 2) residual covariance S of stiffness and bending.
    """

    pressures: Array
    planes: Array
    spread: Array
    residual_covariance: Array

    @classmethod
    def fit(cls, rows: Array) -> Scatter:
        """Fit the planes to rows (n, 4) of phi [rad], P1, P2 [bar], Keq [Nm/rad]; n >= 4, pressures not on one line."""
        X, responses = np.c_[np.ones(len(rows)), rows[:, 1:3]], rows[:, [3, 0]]
        planes: Array = np.asarray(np.linalg.lstsq(X, responses, rcond=None)[0], dtype=float)
        residuals: Array = responses - X @ planes
        return cls(rows[:, 1:3], planes, np.linalg.inv(X.T @ X), residuals.T @ residuals / (len(rows) - 3))

    @property
    def residual(self) -> tuple[float, float]:
        """Standard deviations of one measurement about the planes: stiffness [Nm/rad], bending [rad]."""
        keq, phi = np.sqrt(np.diag(self.residual_covariance)).tolist()
        return keq, phi

    def coefficient_covariance(self, response: int) -> Array:
        """Return the covariance (3, 3) of the coefficients of 1, P1, P2, for response 0 (stiffness) or 1 (bending)."""
        return np.asarray(self.spread * self.residual_covariance[response, response])

    def leverage(self, pressures: Array) -> Array:
        """Return the leverage h (...) at pressures (..., 2): the variance of the plane relative to that of one measurement."""
        x = np.concatenate([np.ones((*pressures.shape[:-1], 1)), pressures], axis=-1)
        return np.asarray(np.einsum("...i,ij,...j->...", x, self.spread, x))

    def at(self, pressures: Array, keq: Array, phi: Array, *, stiffness_known: bool) -> PressureUncertainty:
        """Return standard deviations at pressures (..., 2) where the map gives ``keq`` and ``phi`` (...)."""
        S = self.residual_covariance * (np.outer([0, 1], [0, 1]) if stiffness_known else 1.0)
        one = {
            "keq": np.full(phi.shape, np.sqrt(S[0, 0])),
            "phi": np.full(phi.shape, np.sqrt(S[1, 1])),
            "tau": np.sqrt(phi**2 * S[0, 0] + 2 * phi * keq * S[0, 1] + keq**2 * S[1, 1]),
        }
        h = self.leverage(pressures)
        mean = {f"{name}_mean": value * np.sqrt(h) for name, value in one.items()}
        single = {f"{name}_single": value * np.sqrt(1 + h) for name, value in one.items()}
        return PressureUncertainty(**mean, **single, extrapolates=~self.covers(pressures))

    def covers(self, pressures: Array) -> NDArray[np.bool_]:
        """Return whether pressures (..., 2) are within the convex hull of the measured ones."""
        from scipy.spatial import ConvexHull  # late import: slow to load, seldom needed

        sides = ConvexHull(self.pressures).equations  # (sides, 3): outward normal and offset
        return np.asarray(np.all(pressures @ sides[:, :2].T + sides[:, 2] <= 1e-9, axis=-1))
