"""Error on trials that were not fitted: leave one trial out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.identification.evaluation import predict, residuals, rms
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.fit import fit as fit_to
from hsr_pin.identification.nuisance import taken_out
from hsr_pin.identification.step import damped_step
from hsr_pin.trajectory import Array

#: Share of the diagonal of the normal matrix that is added to it.
_DAMPING = 0.02
#: A run that is foretold so many times worse than it is fitted is looked at again, if no more than so many are.
_FAR, _AGAIN = 3.0, 4


def leave_one_out(experiment: Experiment, fit: Fit) -> list[Array]:
    """For each run (T, M, A) [m] predicted minus measured, with parameters fitted to the other runs.

    The parameters without a run are one Gauss-Newton step away from those with all of them, whose derivatives are known: no fit
    is repeated, every run is simulated once more. Where that is far worse than the fit, the step may have gone too far: the
    fit is repeated there.
    """
    rows = fit.whitened()
    values = [without(fit, rows[:run] + rows[run + 1 :]) for run in range(len(rows))]
    missed = residuals(experiment, predict(experiment, fit.hypothesis, list(zip(experiment.runs, values, strict=True))))
    far = [k for k, (there, here) in enumerate(zip(missed, fit.missed, strict=True)) if rms([there]) > _FAR * rms([here])]
    for k in far if len(rows) > 1 and len(far) <= _AGAIN else ():
        others = replace(experiment, runs=experiment.runs[:k] + experiment.runs[k + 1 :])
        again = fit_to(others, fit.hypothesis, start=fit.values, quick=True).values
        alone = replace(experiment, runs=(experiment.runs[k],))
        (missed[k],) = residuals(alone, predict(alone, fit.hypothesis, [(experiment.runs[k], again)]))
    return taken_out(missed, fit.weights, fit.nuisance, experiment.lasting)


def without(fit: Fit, others: Sequence[tuple[Array, Array]]) -> Array:
    """(P,) parameters fitted to other runs alone, of which :meth:`Fit.whitened` tells; without any, the hypothesis' start."""
    if not others:
        return fit.hypothesis.start
    scale, (lower, upper) = fit.hypothesis.scale, fit.hypothesis.bounds
    residual, slopes = (np.concatenate(part) for part in zip(*others, strict=True))
    # along directions that the other runs cannot tell, the parameters stay where they were
    step = np.clip(damped_step(slopes * scale, residual, _DAMPING), -2.0, 2.0)
    return np.asarray(np.clip(fit.values + scale * step, lower, upper))
