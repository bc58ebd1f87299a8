"""Bounded, robust least squares on distances, weighted by the noise floor."""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.inference.misfit import Misfit
from hsr_pin.inference.own_numbers import Eliminated, prices
from hsr_pin.inference.problem import Hypothesis, Problem
from hsr_pin.inference.residuals import rms
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Relative change of cost and values at which a fit has converged, and evaluations at most; the same of a quick look.
_FULL, _QUICK = (1e-4, 25), (1e-2, 7)
#: A value is on a bound that is nearer than this share of the way from bound to bound.
_AT = 1e-3
#: Searches in a fit at most, and the change [over the scales] that needs no other.
_PASSES, _SETTLED = 4, 2e-2


@dataclass(frozen=True, eq=False)
class Fit:
    """Where a fit ended.

    Attributes:
        hypothesis: what was fitted (:class:`~hsr_pin.inference.problem.Hypothesis`).
        values: (P,) of its open parameters.
        residuals: for each run (T, M, A) predicted minus measured, without what belongs to the trial.
        missed: for each run the same with it.
        slopes: for each run (T, M, A, P) derivatives of the prediction there.
        weights: for each run (T, M, A) with which the residuals counted; zero in gaps.
        nuisance: for each run (T, M, A, K) what one standard deviation of each number of the trial's own makes.
        price: (K,) of these: see :func:`hsr_pin.inference.own_numbers.prices`.
        converged: whether the search came to its end.
        evaluations: how many times all runs were simulated.
        failed: names of the trials whose simulation ends early there.
    """

    hypothesis: Any
    values: Array
    residuals: tuple[Array, ...]
    missed: tuple[Array, ...]
    slopes: tuple[Array, ...]
    weights: tuple[Array, ...]
    nuisance: tuple[Array, ...]
    price: Array
    converged: bool
    evaluations: int
    failed: tuple[str, ...] = ()

    @property
    def rms(self) -> float:
        """RMS distance on the trials that were fitted."""
        return rms(self.residuals)

    @property
    def named(self) -> dict[str, float]:
        """The values by name."""
        return dict(zip(self.hypothesis.free, map(float, self.values), strict=True))

    def eliminated(self, run: int, part: Any = 1.0) -> Eliminated:
        """How a run's own numbers, priced, are taken out of (n, ...) weighted residuals or derivatives."""
        weights = self.weights[run] * part
        priced = self.nuisance[run] / self.price[: self.nuisance[run].shape[-1]]
        return Eliminated.of((priced * weights[..., None])[weights > 0])

    def whitened(self) -> list[tuple[Array, Array]]:
        """For each run (n,) weighted residuals and (n, P) derivatives, without gaps and what belongs to the trial."""
        rows = []
        for run, (missed, slopes, weights) in enumerate(zip(self.missed, self.slopes, self.weights, strict=True)):
            seen, without = weights > 0, self.eliminated(run)
            rows.append((without((np.nan_to_num(missed) * weights)[seen]), without((slopes * weights[..., None])[seen])))
        return rows

    def on_bound(self) -> tuple[str, ...]:
        """Names of parameters that ended on a bound which is not their neutral value."""
        return tuple(
            fact.name
            for fact, value in zip(self.hypothesis.parameters, self.values, strict=True)
            if any(_near(value, bound, fact) for bound in (fact.lower, fact.upper) if bound != fact.neutral)
        )


def _near(value: float, bound: float, fact: Parameter) -> bool:
    """Whether a value is on a bound; of a ratio by its logarithm."""
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
    """Fit the open parameters of a model to recordings.

    Args:
        problem: what to fit to, and who simulates it.
        hypothesis: the model and what is open in it.
        start: (P,) values to start from; default: those of the hypothesis.
        quick: stop early: enough to see which of many models are worth a full fit.
        spread: residual [in noise floors] beyond which a coordinate counts as an outlier (soft-L1 loss); default: six times
            the robust spread at the start.
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
    predictions, plain, missed, nuisance = misfit.predictions(x), misfit.missed(x), misfit.left(x), misfit.nuisance(x)
    if not quick:  # a search is steered well enough by one-sided differences; intervals and null directions want better ones
        predictions = problem.predict_with_slopes(hypothesis, x * misfit.scale, central=True, own=False)
    weights = [
        w / (1 + (np.nan_to_num(r) * w / spread) ** 2) ** 0.25 for r, w in zip(missed, misfit.weights, strict=True)
    ]  # of the soft-L1 loss at the optimum
    return Fit(
        hypothesis=hypothesis,
        values=x * misfit.scale,
        residuals=tuple(missed),
        missed=tuple(plain),
        slopes=tuple(p.slopes for p in predictions if p.slopes is not None),
        weights=tuple(weights),
        nuisance=tuple(nuisance),
        price=prices(missed, weights, problem.doubted),
        converged=converged,
        evaluations=misfit.evaluations,
        failed=tuple(run.name for run, p in zip(problem.runs, predictions, strict=True) if p.failed),
    )


def _searched(misfit: Misfit, x: Array, spread: float, quick: bool) -> tuple[Array, bool]:
    """Where a search from ``x`` (P,) ends, and whether it came to its end.

    What the numbers of the trials make of the residuals is held within a search; a full one is carried on until that is settled.
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
