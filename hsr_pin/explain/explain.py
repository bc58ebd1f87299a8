"""Which cause a model of your own lacks, where the gap lies, and how far it shrinks: from trials to an explanation."""

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
from hsr_pin.explain.recordings import Missing, Recordings, Variant
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
from hsr_pin.inference.search import Search, judged, search
from hsr_pin.inference.verdict import Limits, Vocabulary, predicted_no_better, verdict_of
from hsr_pin.parallel import workers
from hsr_pin.trajectory import Array


def floors(distance: float) -> str:
    """A distance as text."""
    return f"{distance:.2g} floors"


#: How a verdict on two sessions calls what it speaks of.
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
        "ambiguous": "More than one change explains it",
        "unexplained": "Something has changed, and nothing known explains it",
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
    """Say which of its causes a model lacks, with evidence.

    Args:
        model: your own.
        trials: what was recorded; two at least, so that each can be predicted by a fit to the others.
        causes: names of those that are tried; default: all of the model's.
        max_causes: at most this many together.
        test: names of trials that are set aside: nothing is fitted to them, and the ladder is told on them.
        experiments: trials that could be recorded next (what is measured in them counts for nothing): the one in which the
            alternatives are farthest apart is proposed.
        jobs: processes; None: one per core. With more than one, the model's functions must be importable by name.
        executor: in place of processes here.
        loss: what each report gains where it is right and loses where it is not.
        seed: of the resampling.
        words: how the verdict calls what it speaks of.
        tell: called with a line at each stage.
        advance: called after each fit.

    Raises:
        InputError: too few trials, an unknown cause, or predictions that do not belong to the trials.
    """
    if executor is not None or jobs != 1:
        _check_importable(model)
    whole = Recordings(model, trials)
    aside, used = _split(whole, test)
    chosen = model.causes if causes is None else [model.cause(name) for name in dict.fromkeys(causes)]
    parts = [variant for cause in chosen for variant in Missing.variants(cause)]
    variants = Counter(part.name for part in parts)
    limits = Limits.of(float(np.sqrt(np.mean(used.noise**2))), float(np.sqrt(np.mean(1 - np.minimum(used.noise, 1.0) ** 2))))
    words = words or Vocabulary("the fitted parameters" if model.parameters else "the declared numbers", floors, {})
    nominal = _missed(used, Variant(model))
    with workers(jobs, None, executor) as executor:
        tell("the model without causes")
        pool = FitPool(used, executor, variants, advance)
        base = candidate(used, fit(used, Variant(model)), variants)
        most = max_causes if np.sqrt(base.model.misfit) > limits.closed else 0
        found_models = search([base], parts, pool, data_of(used), calibrated(), max_effects=most, tell=tell)
    found = judged(found_models, data_of(used), calibrated())
    verdict = verdict_of(found, limits, lasting_square(nominal), words, loss=loss)
    declared = (words.declared, (), _missed(aside or used, Variant(model)))
    rungs = [declared, *_rungs(found, aside)]
    if aside:
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
    """Say which number of a model, or which of its causes, differs between two sessions.

    The earlier session is explained first. What its best model misses in both sessions alike says nothing of a change: trials of
    the same name are compared with one another, and the difference between them with the difference that each change would make.

    Args:
        model: your own.
        new: trials of the later session.
        old: those of the earlier one, with the same inputs under the same names.
        known: values of the earlier session, as :attr:`Explanation.values` of its explanation has them; default: it is explained.
        words: how the verdict calls what it speaks of.
        options: as of :func:`explain`.

    Raises:
        InputError: fewer than two trials of the one session have a counterpart of as many samples in the other.
    """
    earlier = {trial.name: trial for trial in old}
    pairs = [(each, earlier[each.name]) for each in new if each.name in earlier]
    pairs = [(late, early) for late, early in pairs if np.shape(late.time) == np.shape(early.time)]
    if len(pairs) < 2:
        raise InputError("trials", expected="two or more with the same name and as many samples in both", received=len(pairs))
    change = Change(model, dict(known or explain(model, old, **options).values), Recordings(model, [early for _, early in pairs]))
    return explain(change.as_model, [_difference(late, early) for late, early in pairs], words=words or CHANGE, **options)


def _difference(late: Trial, early: Trial) -> Trial:
    """What was measured later minus what was measured earlier."""
    measured = {channel: np.asarray(late.measured[channel]) - np.asarray(early.measured[channel]) for channel in late.measured}
    own = {name: size * 2**0.5 for name, size in late.own.items()}  # of both
    return Trial(late.name, late.time, measured, (late, early), late.labels, own)


def _check_importable(model: Model) -> None:
    """Refuse functions that other processes cannot have.

    Raises:
        InputError: one that cannot be pickled.
    """
    try:
        pickle.dumps(model)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        hint = "use jobs=1, or functions that a module defines"
        raise InputError("model", expected="functions that other processes can import", received=str(error), hint=hint) from error


def _split(whole: Recordings, test: Sequence[str]) -> tuple[Recordings | None, Recordings]:
    """The trials set aside, if any, and the others."""
    names = {run.name for run in whole.runs}
    if unknown := [name for name in test if name not in names]:
        raise InputError("test", expected=f"names among {', '.join(sorted(names))}", received=unknown[0])
    used = [run for run in whole.runs if run.name not in test]
    if len(used) < 2:
        raise InputError("trials", expected="two or more to fit to", received=len(used))
    aside = [run for run in whole.runs if run.name in test]
    return (whole.of_runs(aside) if aside else None), whole.of_runs(used)


def _missed(recordings: Recordings, variant: Variant, values: Array | None = None) -> list[Array]:
    """For each run (T, M, 1) predicted minus measured, without what the numbers of the trial explain."""
    misfit = Misfit(recordings, variant)
    return misfit.left((variant.start if values is None else values) / misfit.scale)


def _rungs(found: Search, aside: Recordings | None) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
    """Name, causes and residuals on held-out trials of the models on the way to the best; on the trials set aside, if any."""

    def heldout(each: Candidate) -> Sequence[Array]:
        return each.heldout if aside is None else _missed(aside, each.fit.hypothesis, each.fit.values)

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
    """The experiments in which the two nearest alternatives are farthest apart, over the noise."""
    rivals = found.leaders(alternatives)
    if len(rivals) < 2:
        return ()
    separations = []
    for trial in experiments:
        cases = [(each.fit.hypothesis.named(each.fit.values), trial) for each in rivals]
        seen = [np.stack([each[channel] for channel in used.channels], axis=1) / used.units for each in model.outputs(cases)]
        apart = [float(np.sqrt(np.nanmean((one - other) ** 2))) for one, other in itertools.combinations(seen, 2)]
        separations.append((trial.name, min(apart)))
    return tuple(sorted(separations, key=lambda each: -each[1]))
