"""The best model of the reference recording: stiffness and damping, and the effects that explain most of the remaining gap.

It has few effects and no flexible laws, because an overfitted model would not predict the current recording. Its remaining
residuals are modelled in `discrepancy`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.inference.candidate import Candidate, candidate
from hsr_pin.inference.fit import fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.proposals import Proposal
from hsr_pin.inference.resampling import significantly_better
from hsr_pin.inference.screening import laws_first

#: Number of quick fits and of full fits for each further effect.
_QUICK_FITS, _FULL_FITS = 6, 3
#: Least share of the mean square beyond noise on held-out trials that a further effect must explain.
_HELPS = 0.5
#: Factor beyond which the fitted damping counts as far from the declared one.
_ELSEWHERE = 1.5
#: Least share of the mean square that each further parameter of a law must explain.
_NUMBER = 0.1


def described(
    experiment: Experiment,
    hypothesis: Hypothesis,
    parts: Sequence[Part],
    pool: FitPool,
    *,
    max_effects: int = 3,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
) -> Candidate:
    """Return the best model of a recording, where each effect improves the prediction of held-out trials.

    Unlike a diagnosis, which compares many models, a description needs only one accurate model.
    """
    base = fit(experiment, hypothesis)
    best = candidate(experiment, base, {})
    noise = experiment.noise_rms**2
    while len(best.names) < max_effects:
        tell(f"describing the first recording: effect {len(best.names) + 1}")
        ranked = sorted(
            pool.propose([(best, [part for part in parts if part.name not in best.names])])[0],
            key=lambda proposal: -proposal.gain,
        )
        tasks = [(best.fit, each) for proposal in ranked[:_QUICK_FITS] for each in (proposal, *_as_declared(proposal, best))]
        quick = laws_first(sorted(pool.quick(tasks), key=lambda fitted: fitted.rms))
        better = min(pool.full(quick[:_FULL_FITS]), key=_cost, default=best)
        helps = best.heldout_square - better.heldout_square > _HELPS * (best.heldout_square - noise)
        if not helps or not significantly_better(better.heldout, best.heldout, seed):
            break
        best = better
    return best


def _as_declared(proposal: Proposal, best: Candidate) -> tuple[Proposal, ...]:
    """Return the same proposal with the declared damping, if the fitted damping is far from it.

    A slow actuator and a damped arm are two lags in series that can be exchanged, so that the fit has a second minimum.
    """
    if abs(np.log(best.fit.named["damping_scale"])) < np.log(_ELSEWHERE):
        return ()
    at = proposal.hypothesis.free.index("damping_scale")
    return (replace(proposal, starts=tuple(np.where(np.arange(len(each)) == at, 1.0, each) for each in proposal.starts)),)


def _cost(candidate: Candidate) -> float:
    """Return the mean square on held-out trials, increased for every parameter [m^2]."""
    return candidate.heldout_square * (1 + _NUMBER) ** len(candidate.fit.values)
