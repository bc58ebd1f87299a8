"""Explanation of a model's gap: the causes that are missing, where the gap lies, and how much each cause explains."""

from __future__ import annotations

import itertools
import pickle
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.explain.change import Change
from hsr_pin.explain.model import Model, Trial
from hsr_pin.explain.recordings import CauseVariant, ExtendedModel, Recordings
from hsr_pin.explain.result import Explanation
from hsr_pin.explain.where import locate
from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.candidate import Candidate, candidate, data_of
from hsr_pin.inference.decision import Loss
from hsr_pin.inference.fit import fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.ladder import ladder
from hsr_pin.inference.misfit import Misfit
from hsr_pin.inference.resampling import squares
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.inference.search import Search, judged, search, with_detection_limits
from hsr_pin.inference.verdict import Limits, Vocabulary, predicted_no_better, verdict_of
from hsr_pin.parallel import open_executor
from hsr_pin.trajectory import Array


def floors(distance: float) -> str:
    """Return a distance as text, in floors."""
    return f"{distance:.2g} floors"


#: Vocabulary of a verdict on two sessions.
CHANGE = Vocabulary(
    fitted="unchanged numbers",
    size=floors,
    kinds={},
    missing="different in the later session",
    nothing=("unchanged", "The two sessions agree"),
    declared="nothing has changed",
    headlines={
        "identified": "What has changed is identified",
        "partly_identified": "What has changed is identified in part",
        "ambiguous": "More than one change explains the difference",
        "unexplained": "Something has changed, and no known change explains it",
        "unchanged": "Nothing has changed",
    },
)


def explain(
    model: Model,
    trials: Sequence[Trial],
    *,
    causes: Sequence[str] | None = None,
    max_causes: int = 3,
    test: Sequence[str] = (),
    experiments: Sequence[Trial] = (),
    jobs: int | None = 1,
    executor: Executor | None = None,
    loss: Loss | None = None,
    seed: int = 0,
    words: Vocabulary | None = None,
    tell: Callable[[str], None] = lambda line: None,
    advance: Callable[[], None] = lambda: None,
) -> Explanation:
    """Find out which of its causes a model lacks, and return the explanation with its evidence.

    Args:
        model: the user's model.
        trials: recorded trials; at least two, so that each can be predicted by a fit to the others.
        causes: names of the causes that are tried; default: all causes of the model.
        max_causes: largest number of causes in one model.
        test: names of held-out trials: nothing is fitted to them, and they are used for the ladder.
        experiments: trials that could be recorded next (their measured values are ignored); the one that separates the
            alternatives best is proposed.
        jobs: number of processes; None: one per core. With more than one, the model's functions must be importable by name.
        executor: executor to use instead of local processes.
        loss: gains and losses of a report.
        seed: seed of the resampling.
        words: vocabulary of the verdict.
        tell: function that receives a progress message at each stage.
        advance: called after each fit.

    Raises:
        InputError: there are too few trials, a cause is unknown, or the predictions do not fit the trials.
    """
    if executor is not None or jobs != 1:
        _check_importable(model)
    whole = Recordings(model, trials)
    heldout, used = _split(whole, test)
    chosen = model.causes if causes is None else [model.cause(name) for name in dict.fromkeys(causes)]
    parts = [variant for cause in chosen for variant in CauseVariant.variants(cause)]
    variants = Counter(part.name for part in parts)
    limits = Limits.of(float(np.sqrt(np.mean(used.noise**2))), float(np.sqrt(np.mean(1 - np.minimum(used.noise, 1.0) ** 2))))
    words = words or Vocabulary("the fitted parameters" if model.parameters else "the declared numbers", floors, {})
    nominal = _residuals(used, ExtendedModel(model))
    with open_executor(jobs, None, executor) as executor:
        tell("fitting the model without causes")
        pool = FitPool(used, executor, variants, advance)
        base = candidate(used, fit(used, ExtendedModel(model)), variants)
        most = max_causes if np.sqrt(base.model.misfit) > limits.closed else 0
        found_models = search([base], parts, pool, data_of(used), calibrated(), max_effects=most, tell=tell)
        found = judged(found_models, data_of(used), calibrated())
        found = with_detection_limits(found, used, parts, pool, calibrated(), limits.closed**2)
    verdict = verdict_of(found, limits, lasting_square(nominal), words, loss=loss)
    declared = (words.declared, (), _residuals(heldout or used, ExtendedModel(model)))
    rungs = [declared, *_rungs(found, heldout)]
    if heldout:
        alone, best = (squares(rungs[k][2]).mean ** 0.5 for k in (bool(model.parameters), -1))
        verdict = predicted_no_better(verdict, alone, best, found.best.names, words)
    return Explanation(
        recordings=used,
        verdict=verdict,
        ladder=ladder(rungs, limits.noise, seed),
        search=found,
        limits=limits,
        nominal=tuple(nominal),
        where=locate(used, found.base.heldout),
        next_experiment=_next(model, found, verdict.alternatives, experiments, used),
        loss=loss or Loss(),
        words=words,
    )


def explain_change(
    model: Model,
    new: Sequence[Trial],
    old: Sequence[Trial],
    *,
    known: Mapping[str, float] | None = None,
    words: Vocabulary | None = None,
    **options: Any,
) -> Explanation:
    """Find out which parameter of a model, or which of its causes, differs between two sessions.

    The earlier session is explained first. An error of its best model that is equal in both sessions is no evidence of a change.
    Therefore trials of the same name are compared, and their difference is compared with the predicted difference of each change.

    Args:
        model: the user's model.
        new: trials of the later session.
        old: trials of the earlier session, with the same inputs under the same names.
        known: parameter values of the earlier session (:attr:`Explanation.values` of its explanation); default: it is explained
            first.
        words: vocabulary of the verdict.
        options: further arguments of :func:`explain`.

    Raises:
        InputError: fewer than two trials have a counterpart with the same number of samples in the other session.
    """
    earlier = {trial.name: trial for trial in old}
    pairs = [(each, earlier[each.name]) for each in new if each.name in earlier]
    pairs = [(late, early) for late, early in pairs if np.shape(late.time) == np.shape(early.time)]
    if len(pairs) < 2:
        raise InputError("trials", expected="two or more with the same name and as many samples in both", received=len(pairs))
    change = Change(model, dict(known or explain(model, old, **options).values), Recordings(model, [early for _, early in pairs]))
    return explain(change.as_model, [_difference(late, early) for late, early in pairs], words=words or CHANGE, **options)


def _difference(late: Trial, early: Trial) -> Trial:
    """Return a trial with the later measurement minus the earlier one."""
    measured = {channel: np.asarray(late.measured[channel]) - np.asarray(early.measured[channel]) for channel in late.measured}
    own = {name: size * 2**0.5 for name, size in late.own.items()}  # the variances of both trials add up
    return Trial(late.name, late.time, measured, (late, early), late.labels, own)


def _check_importable(model: Model) -> None:
    """Check that a model can be sent to other processes.

    Raises:
        InputError: one of its functions cannot be pickled.
    """
    try:
        pickle.dumps(model)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        hint = "use jobs=1, or functions that a module defines"
        raise InputError("model", expected="functions that other processes can import", received=str(error), hint=hint) from error


def _split(whole: Recordings, test: Sequence[str]) -> tuple[Recordings | None, Recordings]:
    """Return the held-out trials, if any, and the other trials."""
    names = {run.name for run in whole.runs}
    if unknown := [name for name in test if name not in names]:
        raise InputError("test", expected=f"names among {', '.join(sorted(names))}", received=unknown[0])
    used = [run for run in whole.runs if run.name not in test]
    if len(used) < 2:
        raise InputError("trials", expected="two or more to fit to", received=len(used))
    heldout = [run for run in whole.runs if run.name in test]
    return (whole.of_runs(heldout) if heldout else None), whole.of_runs(used)


def _residuals(recordings: Recordings, variant: ExtendedModel, values: Array | None = None) -> list[Array]:
    """Return for each run (T, M, 1) predicted minus measured, with the trial parameters eliminated."""
    misfit = Misfit(recordings, variant)
    return misfit.reduced_residuals((variant.start if values is None else values) / misfit.scale)


def _rungs(found: Search, test: Recordings | None) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
    """Return name, causes and held-out residuals of the models from the base model to the best one."""

    def heldout(each: Candidate) -> Sequence[Array]:
        return each.heldout if test is None else _residuals(test, each.fit.hypothesis, each.fit.values)

    path = found.path
    rungs: list[tuple[str, tuple[str, ...], Sequence[Array]]] = []
    if found.base.fit.hypothesis.parameters:
        rungs.append(("fitted parameters", (), heldout(path[0])))
    for before, after in itertools.pairwise(path):
        rungs.append((" + ".join(sorted(set(after.names) - set(before.names))), after.names, heldout(after)))
    return rungs


def _next(
    model: Model, found: Search, alternatives: Sequence[tuple[str, ...]], experiments: Sequence[Trial], used: Recordings
) -> tuple[tuple[str, float], ...]:
    """Return the proposed experiments with the smallest distance between any two alternatives [floors], the largest first."""
    rivals = found.leaders(alternatives)
    if len(rivals) < 2:
        return ()
    separations = []
    for trial in experiments:
        cases = [(each.fit.hypothesis.named(each.fit.values), trial) for each in rivals]
        seen = [np.stack([each[channel] for channel in used.channels], axis=1) / used.units for each in model.outputs(cases)]
        distances = [float(np.sqrt(np.nanmean((one - other) ** 2))) for one, other in itertools.combinations(seen, 2)]
        separations.append((trial.name, min(distances)))
    return tuple(sorted(separations, key=lambda each: -each[1]))
