"""Bounded, robust least squares on distances, weighted by the noise floor."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import log
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.inference.misfit import Misfit
from hsr_pin.inference.problem import Hypothesis, Problem
from hsr_pin.inference.residuals import rms
from hsr_pin.inference.trial_parameters import Eliminated, trial_inflation, without_trial_parameters
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Relative tolerance of cost and values, and largest number of evaluations: of a full fit, and of a quick fit.
_FULL, _QUICK = (1e-4, 25), (1e-2, 7)
#: A value is on a bound if its distance is less than this share of the range between the bounds.
_AT = 1e-3
#: Largest number of optimisations in a fit, and the change [in scales] below which no further one is needed.
_PASSES, _SETTLED = 4, 2e-2


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit.

    Attributes:
        hypothesis: the fitted model (:class:`~hsr_pin.inference.problem.Hypothesis`).
        values: (P,) values of its free parameters.
        residuals: for each run (T, M, A) predicted minus measured, with the trial parameters eliminated.
        raw_residuals: for each run (T, M, A) predicted minus measured, without this elimination; the predictions include the most
            probable errors of declared numbers.
        slopes: for each run (T, M, A, P) derivatives of the prediction at the values.
        weights: for each run (T, M, A) weights of the residuals; zero in gaps.
        nuisance: for each run (T, M, A, K) change of the prediction for one prior standard deviation of each trial parameter.
        noise_inflation: (K,) factors by which the noise exceeds white noise, as seen by each trial parameter; see
            :func:`hsr_pin.inference.trial_parameters.trial_inflation`.
        converged: whether the optimiser converged.
        evaluations: number of times that all runs were simulated.
        failed: names of the trials whose simulation fails at the values.
        errors: (K,) most probable errors of declared numbers, in standard deviations.
    """

    hypothesis: Any
    values: Array
    residuals: tuple[Array, ...]
    raw_residuals: tuple[Array, ...]
    slopes: tuple[Array, ...]
    weights: tuple[Array, ...]
    nuisance: tuple[Array, ...]
    noise_inflation: Array
    converged: bool
    evaluations: int
    failed: tuple[str, ...] = ()
    errors: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def rms(self) -> float:
        """RMS distance on the fitted trials."""
        return rms(self.residuals)

    @property
    def named(self) -> dict[str, float]:
        """Parameter values by name."""
        return dict(zip(self.hypothesis.free, map(float, self.values), strict=True))

    def eliminated(self, run: int, part: Any = 1.0) -> Eliminated:
        """Return the operator that eliminates the trial parameters of a run from (n, ...) weighted residuals or derivatives."""
        weights = self.weights[run] * part
        scaled = self.nuisance[run] / self.noise_inflation[: self.nuisance[run].shape[-1]]
        return Eliminated.of((scaled * weights[..., None])[weights > 0])

    def whitened(self) -> list[tuple[Array, Array]]:
        """Return for each run the weighted residuals (n,) and derivatives (n, P), without gaps and trial parameters."""
        rows = []
        for run, (residuals, slopes, weights) in enumerate(zip(self.raw_residuals, self.slopes, self.weights, strict=True)):
            seen, without = weights > 0, self.eliminated(run)
            rows.append((without((np.nan_to_num(residuals) * weights)[seen]), without((slopes * weights[..., None])[seen])))
        return rows

    def on_bound(self) -> tuple[str, ...]:
        """Return the names of parameters that ended on a bound other than their neutral value."""
        return tuple(
            fact.name
            for fact, value in zip(self.hypothesis.parameters, self.values, strict=True)
            if any(_near(value, bound, fact) for bound in (fact.lower, fact.upper) if bound != fact.neutral)
        )


def _near(value: float, bound: float, fact: Parameter) -> bool:
    """Return whether a value is on a bound; factors are compared by their logarithms."""
    if fact.ratio_width is not None and value > 0:
        return abs(log(value / bound)) < _AT * log(fact.upper / fact.lower)
    return abs(value - bound) < _AT * (fact.upper - fact.lower)


def fit(
    problem: Problem,
    hypothesis: Hypothesis,
    *,
    start: Array | None = None,
    quick: bool = False,
    spread: float | None = None,
) -> Fit:
    """Fit the free parameters of a model to recordings.

    Args:
        problem: the recordings and their simulation.
        hypothesis: the model and its free parameters.
        start: (P,) initial values; default: those of the hypothesis.
        quick: stop early, which is enough to select the models that get a full fit.
        spread: residual [in noise floors] beyond which a coordinate counts as an outlier (soft-L1 loss); default: six times the
            robust spread at the initial values.
    """
    misfit = Misfit(problem, hypothesis)
    lower, upper = misfit.lower, misfit.upper
    x = np.clip((hypothesis.start if start is None else np.asarray(start)) / misfit.scale, lower, upper)
    if spread is None:
        spread = max(6.0, 6.0 * float(np.median(np.abs(misfit.residual(x))) / 0.6745))
    converged = True
    if len(x):
        x = np.clip(x, lower + 1e-9 * (upper - lower), upper - 1e-9 * (upper - lower))
        x, converged = _searched(misfit, x, spread, quick)
    predictions = misfit.predictions(x)
    errors, nuisance = misfit.errors(x), misfit.nuisance(x)
    raw_residuals = [
        residual + problem.tolerances(run) @ errors for residual, run in zip(misfit.raw_residuals(x), problem.runs, strict=True)
    ]
    reduced = without_trial_parameters(raw_residuals, misfit.weights, nuisance, problem)
    if not quick:  # one-sided differences suffice for the optimiser, not for intervals and null directions
        predictions = problem.predict_with_slopes(hypothesis, x * misfit.scale, central=True, own=False)
    weights = [
        w / (1 + (np.nan_to_num(r) * w / spread) ** 2) ** 0.25 for r, w in zip(reduced, misfit.weights, strict=True)
    ]  # those of the soft-L1 loss at the optimum
    return Fit(
        hypothesis=hypothesis,
        values=x * misfit.scale,
        residuals=tuple(reduced),
        raw_residuals=tuple(raw_residuals),
        slopes=tuple(p.slopes for p in predictions if p.slopes is not None),
        weights=tuple(weights),
        nuisance=tuple(nuisance),
        noise_inflation=trial_inflation(raw_residuals, weights, nuisance, problem),
        converged=converged,
        evaluations=misfit.evaluations,
        errors=errors,
        failed=tuple(run.name for run, p in zip(problem.runs, predictions, strict=True) if p.failed),
    )


def _searched(misfit: Misfit, x: Array, spread: float, quick: bool) -> tuple[Array, bool]:
    """Return the values at which the optimiser ends, starting from ``x`` (P,), and whether it converged.

    The elimination of trial parameters is frozen during one optimisation; a full fit repeats the optimisation until it is
    consistent.
    """
    tolerance, evaluations = _QUICK if quick else _FULL
    for _ in range(1 if quick else _PASSES):
        own = misfit.hold(x)
        answer = least_squares(
            misfit.residual,
            x,
            jac=misfit.jacobian,
            bounds=(misfit.lower, misfit.upper),
            loss="soft_l1",
            f_scale=spread,
            ftol=tolerance,
            xtol=tolerance,
            max_nfev=evaluations,
        )
        moved = float(np.abs(answer.x - x).max())
        x = answer.x
        if not own or moved < _SETTLED:
            break
    return x, answer.status > 0
