"""Bounded, robust least squares on marker distances, weighted by the noise floor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.identification.evaluation import predict_with_slopes, rms
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.misfit import FINE_LINKS, FINE_STEP, Misfit
from hsr_pin.trajectory import Array

__all__ = ["FINE_LINKS", "FINE_STEP", "Fit", "fit", "stacked"]

#: Of the two rounds: the first need not be exact, the defect changes its answer anyway.
_TOLERANCES = (1e-3, 1e-4)
#: Tolerance and evaluations of a quick look.
_QUICK = (1e-2, 7)


@dataclass(frozen=True, eq=False)
class Fit:
    """Where a fit ended.

    Attributes:
        hypothesis: what was fitted.
        values: (P,) of its open parameters.
        residuals: for each run (T, M, 3) [m] predicted (by the fine chain) minus measured.
        slopes: for each run (T, M, 3, P) derivatives of the prediction there.
        weights: for each run (T, M, 3) [1/m] with which the residuals counted; zero in gaps.
        defects: for each run (T, M, 3) [m] what the coarse chain gets wrong, as far as known.
        converged: whether the search came to its end.
        evaluations: how many times the experiment was simulated.
    """

    hypothesis: Hypothesis
    values: Array
    residuals: tuple[Array, ...]
    slopes: tuple[Array, ...]
    weights: tuple[Array, ...]
    defects: tuple[Array, ...]
    converged: bool
    evaluations: int

    @property
    def rms(self) -> float:
        """RMS marker distance [m] on the trials that were fitted."""
        return rms(self.residuals)

    @property
    def named(self) -> dict[str, float]:
        """The values by name."""
        return dict(zip(self.hypothesis.free, map(float, self.values), strict=True))

    def on_bound(self) -> tuple[str, ...]:
        """Names of parameters that ended on a bound which is not their neutral value."""
        return tuple(
            fact.name
            for fact, value in zip(self.hypothesis.parameters, self.values, strict=True)
            if min(value - fact.lower, fact.upper - value) < 1e-3 * fact.scale and abs(value - fact.neutral) > 1e-3 * fact.scale
        )


def fit(
    experiment: Experiment,
    hypothesis: Hypothesis,
    *,
    start: Array | None = None,
    after: Fit | None = None,
    quick: bool = False,
    corrected: bool = True,
    spread: float | None = None,
    max_evaluations: int = 12,
    tell: Callable[[str], None] | None = None,
) -> Fit:
    """Fit the open parameters of a hypothesis to an experiment.

    The search runs on the hypothesis' own, coarse chain. What that chain and its step get wrong at the optimum (fine minus coarse
    prediction) is then added as a constant and the search goes on from there (defect correction): so the values belong to the
    continuous arm.

    Args:
        experiment: what to fit to.
        hypothesis: the model and what is open in it.
        start: (P,) values to start from; default: those of the hypothesis.
        after: the fit of a like model, whose defect is a first guess of this one's if it has the same chain.
        quick: stop early, and leave the defect at that guess: enough to see which of many models are worth a full fit.
        corrected: False fits the coarse chain as it is: the values then belong to that chain.
        spread: residual [in noise floors] beyond which a coordinate counts as an outlier (soft-L1 loss); default: six times
            the robust spread at the start.
        max_evaluations: of each of the two rounds.
        tell: called with a line now and then.
    """
    misfit = Misfit(experiment, hypothesis, after.defects if after and _same_chain(after.hypothesis, hypothesis) else None)
    lower, upper = misfit.lower, misfit.upper
    x = np.clip((hypothesis.start if start is None else np.asarray(start)) / misfit.scale, lower, upper)
    if spread is None:
        spread = max(6.0, 6.0 * float(np.median(np.abs(misfit.residual(x))) / 0.6745))
    converged = True
    for tolerance in _QUICK[:1] if quick else _TOLERANCES if corrected else _TOLERANCES[1:]:
        x = np.clip(x, lower + 1e-9 * (upper - lower), upper - 1e-9 * (upper - lower))
        answer = least_squares(
            misfit.residual,
            x,
            jac=misfit.jacobian,
            bounds=(lower, upper),
            loss="soft_l1",
            f_scale=spread,
            ftol=tolerance,
            xtol=tolerance,
            max_nfev=_QUICK[1] if quick else max_evaluations,
        )
        x, converged = answer.x, answer.status > 0
        if corrected and not quick:
            misfit.correct(x)
        if tell:
            tell(f"cost {answer.cost:.6g}")
    return _at(misfit, x, spread, converged, central=not quick)


def _same_chain(one: Hypothesis, other: Hypothesis) -> bool:
    return all(getattr(one, name) == getattr(other, name) for name in ("links", "placement", "integrator", "step"))


def _at(misfit: Misfit, x: Array, spread: float, converged: bool, central: bool) -> Fit:
    predictions = misfit.predictions(x)
    if central:  # a search is steered well enough by forward differences; intervals and null directions want better ones
        predictions = predict_with_slopes(misfit.experiment, misfit.hypothesis, x * misfit.scale, central=True)
    missed = misfit.missed(x)
    weights = [
        w / (1 + (np.nan_to_num(r) * w / spread) ** 2) ** 0.25 for r, w in zip(missed, misfit.weights, strict=True)
    ]  # of the soft-L1 loss at the optimum
    return Fit(
        hypothesis=misfit.hypothesis,
        values=x * misfit.scale,
        residuals=tuple(missed),
        slopes=tuple(p.slopes for p in predictions if p.slopes is not None),
        weights=tuple(weights),
        defects=tuple(misfit.defects),
        converged=converged,
        evaluations=misfit.evaluations,
    )


def stacked(fit: Fit, runs: Sequence[int] | None = None) -> tuple[Array, Array]:
    """Weighted residuals (n,) and derivatives (n, P) of some runs (default: all), without gaps."""
    chosen = range(len(fit.residuals)) if runs is None else runs
    rows, slopes = [], []
    for k in chosen:
        mask = fit.weights[k] > 0
        rows.append((np.nan_to_num(fit.residuals[k]) * fit.weights[k])[mask])
        slopes.append((fit.slopes[k] * fit.weights[k][..., None])[mask])
    return np.concatenate(rows), np.concatenate(slopes)
