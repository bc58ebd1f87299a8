"""Error on trials that were not fitted: leave one trial out."""

from __future__ import annotations

import numpy as np

from hsr_pin.identification.evaluation import predict, residuals
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import FINE_LINKS, FINE_STEP, Fit, stacked
from hsr_pin.trajectory import Array


def leave_one_out(experiment: Experiment, fit: Fit) -> list[Array]:
    """For each run (T, M, 3) [m] predicted minus measured, with parameters fitted to the other runs.

    The parameters without a run are one Gauss-Newton step away from those with all of them, whose derivatives are known: no fit
    is repeated, every run is simulated once more, by the fine chain.
    """
    values = [_without(fit, run) for run in range(len(experiment.runs))]
    fine = fit.hypothesis.finer(FINE_LINKS, FINE_STEP)
    cases = list(zip(experiment.runs, values, strict=True))
    return residuals(experiment, predict(experiment, fine, cases))


def _without(fit: Fit, run: int) -> Array:
    """(P,) parameters fitted to all runs but one; with a single run, the hypothesis' start."""
    others = [k for k in range(len(fit.residuals)) if k != run]
    if not others:
        return fit.hypothesis.start
    facts = fit.hypothesis.parameters
    scale = np.array([fact.scale for fact in facts])
    residual, slopes = stacked(fit, others)
    normal = (slopes * scale).T @ (slopes * scale)
    # damped as Marquardt does: along directions that the other runs cannot tell, the parameters stay where they were
    normal += 0.02 * np.diag(np.diag(normal)) + 1e-12 * np.trace(normal) * np.eye(len(scale))
    step = np.clip(-np.linalg.solve(normal, (slopes * scale).T @ residual), -2.0, 2.0)
    lower, upper = np.array([fact.lower for fact in facts]), np.array([fact.upper for fact in facts])
    return np.asarray(np.clip(fit.values + scale * step, lower, upper))
