"""The best model of OLD: stiffness and damping, and the effects that describe most of what these leave.

Few, and no flexible laws: a model that bends to OLD does not foretell NEW. What it leaves has a place of its own (`leftover`).
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
from hsr_pin.inference.resampling import certainly_better
from hsr_pin.inference.screening import laws_first

#: Quick fits, and full ones, for each further effect.
_GLANCES, _FINISHED = 6, 3
#: Share of the mean square beyond noise on held-out trials that a further effect must take away.
_HELPS = 0.5
#: A damping that is another by more than this factor is far from the declared one.
_ELSEWHERE = 1.5
#: Share of the mean square that each number of a law must take away to be preferred to a law with fewer.
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
    """The best model of a recording, each effect added where held-out trials say that it helps.

    A diagnosis asks which of the models can be told apart, and tries many; a description needs but one that is near.
    """
    base = fit(experiment, hypothesis)
    best = candidate(experiment, base, {})
    noise = experiment.noise_rms**2
    while len(best.names) < max_effects:
        tell(f"what describes the first recording: effect {len(best.names) + 1}")
        ranked = sorted(
            pool.propose([(best, [part for part in parts if part.name not in best.names])])[0], key=lambda guess: -guess.gain
        )
        tasks = [(best.fit, each) for guess in ranked[:_GLANCES] for each in (guess, *_as_declared(guess, best))]
        quick = laws_first(sorted(pool.quick(tasks), key=lambda fitted: fitted.rms))
        better = min(pool.full(quick[:_FINISHED]), key=_cost, default=best)
        helps = best.heldout_square - better.heldout_square > _HELPS * (best.heldout_square - noise)
        if not helps or not certainly_better(better.heldout, best.heldout, seed):
            break
        best = better
    return best


def _as_declared(guess: Proposal, best: Candidate) -> tuple[Proposal, ...]:
    """The same guess about an arm that is damped as declared, where the fit is far from that.

    A slow actuator and a damped arm are two lags in a row, and these can be exchanged: the one is a basin beside the other.
    """
    if abs(np.log(best.fit.named["damping_scale"])) < np.log(_ELSEWHERE):
        return ()
    at = guess.hypothesis.free.index("damping_scale")
    return (replace(guess, starts=tuple(np.where(np.arange(len(each)) == at, 1.0, each) for each in guess.starts)),)


def _cost(candidate: Candidate) -> float:
    """[m^2] mean square on held-out trials, more for each number that bends to it."""
    return candidate.heldout_square * (1 + _NUMBER) ** len(candidate.fit.values)
