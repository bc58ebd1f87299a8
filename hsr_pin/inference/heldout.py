"""Prediction errors on held-out trials, by leaving one trial out at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.inference.fit import Fit
from hsr_pin.inference.fit import fit as fit_to
from hsr_pin.inference.misfit import scaled
from hsr_pin.inference.problem import Problem
from hsr_pin.inference.residuals import residuals, rms
from hsr_pin.inference.step import damped_step
from hsr_pin.inference.trial_parameters import without_trial_parameters
from hsr_pin.trajectory import Array

#: Damping: the share of its diagonal that is added to the normal matrix.
_DAMPING = 0.02
#: If the held-out error of a run exceeds its fit error by more than the first factor, a fit without this run replaces the step,
#: unless there are more such runs than the second number.
_FAR, _AGAIN = 3.0, 4


def leave_one_out(problem: Problem, fit: Fit) -> list[Array]:
    """Return for each run (T, M, A) predicted minus measured, with parameters fitted to the other runs.

    The parameters without one run are approximated by one Gauss-Newton step from the fit to all runs, whose derivatives are
    known, so that each run is simulated once and no fit is repeated. If the prediction of a run is much worse than its fit, the
    step may be inaccurate, and a quick fit to the other runs replaces it.
    """
    rows = fit.whitened()
    values = [without(fit, rows[:run] + rows[run + 1 :]) for run in range(len(rows))]
    predicted = residuals(problem, problem.predict(fit.hypothesis, list(zip(problem.runs, values, strict=True))))
    missed = [each + problem.tolerances(run) @ fit.errors for each, run in zip(predicted, problem.runs, strict=True)]
    far = [k for k, (there, here) in enumerate(zip(missed, fit.raw_residuals, strict=True)) if rms([there]) > _FAR * rms([here])]
    for k in far if len(rows) > 1 and len(far) <= _AGAIN else ():
        others = problem.of_runs(problem.runs[:k] + problem.runs[k + 1 :])
        again = fit_to(others, fit.hypothesis, start=fit.values, quick=True).values
        alone = problem.of_runs((problem.runs[k],))
        (predicted[k],) = residuals(alone, alone.predict(fit.hypothesis, [(problem.runs[k], again)]))
        missed[k] = predicted[k] + problem.tolerances(problem.runs[k]) @ fit.errors
    return without_trial_parameters(missed, fit.weights, fit.nuisance, problem)


def without(fit: Fit, others: Sequence[tuple[Array, Array]]) -> Array:
    """Return the parameters (P,) fitted to the runs with the given :meth:`Fit.whitened` rows; without any, the initial values."""
    if not others:
        return np.asarray(fit.hypothesis.start)
    scale, lower, upper = scaled(fit.hypothesis)
    residual, slopes = (np.concatenate(part) for part in zip(*others, strict=True))
    # along directions that the other runs do not determine, the parameters stay unchanged
    step = np.clip(damped_step(slopes * scale, residual, _DAMPING), -2.0, 2.0)
    return np.asarray(np.clip(fit.values + scale * step, lower * scale, upper * scale))
