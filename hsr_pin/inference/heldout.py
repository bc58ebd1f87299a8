"""Error on trials that were not fitted: leave one trial out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.inference.fit import Fit
from hsr_pin.inference.fit import fit as fit_to
from hsr_pin.inference.misfit import scaled
from hsr_pin.inference.own_numbers import taken_out
from hsr_pin.inference.problem import Problem
from hsr_pin.inference.residuals import residuals, rms
from hsr_pin.inference.step import damped_step
from hsr_pin.trajectory import Array

#: Share of the diagonal of the normal matrix that is added to it.
_DAMPING = 0.02
#: A run that is foretold so many times worse than it is fitted is looked at again, if no more than so many are.
_FAR, _AGAIN = 3.0, 4


def leave_one_out(problem: Problem, fit: Fit) -> list[Array]:
    """For each run (T, M, A) predicted minus measured, with parameters fitted to the other runs.

    The parameters without a run are one Gauss-Newton step away from those with all of them, whose derivatives are known: no fit
    is repeated, every run is simulated once more. Where that is far worse than the fit, the step may have gone too far: the
    fit is repeated there.
    """
    rows = fit.whitened()
    values = [without(fit, rows[:run] + rows[run + 1 :]) for run in range(len(rows))]
    missed = residuals(problem, problem.predict(fit.hypothesis, list(zip(problem.runs, values, strict=True))))
    far = [k for k, (there, here) in enumerate(zip(missed, fit.missed, strict=True)) if rms([there]) > _FAR * rms([here])]
    for k in far if len(rows) > 1 and len(far) <= _AGAIN else ():
        others = problem.of_runs(problem.runs[:k] + problem.runs[k + 1 :])
        again = fit_to(others, fit.hypothesis, start=fit.values, quick=True).values
        alone = problem.of_runs((problem.runs[k],))
        (missed[k],) = residuals(alone, alone.predict(fit.hypothesis, [(problem.runs[k], again)]))
    return taken_out(missed, fit.weights, fit.nuisance, problem)


def without(fit: Fit, others: Sequence[tuple[Array, Array]]) -> Array:
    """(P,) parameters fitted to other runs alone, of which :meth:`Fit.whitened` tells; without any, the hypothesis' start."""
    if not others:
        return np.asarray(fit.hypothesis.start)
    scale, lower, upper = scaled(fit.hypothesis)
    residual, slopes = (np.concatenate(part) for part in zip(*others, strict=True))
    # along directions that the other runs cannot tell, the parameters stay where they were
    step = np.clip(damped_step(slopes * scale, residual, _DAMPING), -2.0, 2.0)
    return np.asarray(np.clip(fit.values + scale * step, lower * scale, upper * scale))
