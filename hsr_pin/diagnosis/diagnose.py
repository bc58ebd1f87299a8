"""Where the sim-to-real gap lies, which effect causes it, how far it shrinks: from a dataset to a diagnosis."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.evidence import structure
from hsr_pin.diagnosis.ladder import Rung, ladder
from hsr_pin.diagnosis.next_experiment import Proposal, propose
from hsr_pin.diagnosis.search import Search, Thresholds, mean_square, search, worth_having
from hsr_pin.diagnosis.verdict import Verdict, judge
from hsr_pin.diagnosis.where import Where, locate
from hsr_pin.diagnosis.workers import workers
from hsr_pin.effects import EFFECTS, effect_named
from hsr_pin.effects.effect import Effect, neutral
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.evaluation import predict, residuals
from hsr_pin.identification.experiment import Experiment, moves, prepare
from hsr_pin.identification.fit import FINE_LINKS, FINE_STEP, fit
from hsr_pin.identification.heldout import leave_one_out
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.trajectory import Array, Dataset


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """All that was found.

    Attributes:
        experiment: the recordings as they were used.
        verdict: what may be said.
        ladder: how far each step shrinks the gap.
        search: every model that was tried; None where there was too little to try any.
        thresholds: what counted.
        nominal: for each run (T, M, 3) [m] predicted minus measured by the model as declared.
        where: maps of the gap that fitted stiffness and damping leave; None where there was too little to fit.
        next_experiment: what to record next, the most telling first; empty where the verdict needs no more.
    """

    experiment: Experiment
    verdict: Verdict
    ladder: tuple[Rung, ...]
    search: Search | None
    thresholds: Thresholds
    nominal: tuple[Array, ...]
    where: Where | None = None
    next_experiment: tuple[Proposal, ...] = ()


def diagnose(
    dataset: Dataset,
    *,
    effects: Sequence[str] | None = None,
    max_effects: int = 3,
    links: int = 6,
    declared_links: int = 4,
    jobs: int | None = None,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
    advance: Callable[[], None] = lambda: None,
) -> Diagnosis:
    """Diagnose the sim-to-real gap of a dataset.

    Args:
        dataset: at least two trials in which the arm moves.
        effects: names of the candidates; default: the whole catalogue.
        max_effects: at most this many together.
        links: of the chain that is fitted (it is corrected for its coarseness).
        declared_links: of the declared model, with joints at the links' ends as in the paper.
        jobs: processes; default: one per core.
        seed: of the resampling.
        tell: called with a line at each stage.
        advance: called after each fit.

    Raises:
        IdentificationError: nothing in the dataset can be compared with a model, or an argument is out of range.
        EffectError: an unknown effect.
    """
    candidates = _templates(effects)
    if max_effects < 0:
        raise IdentificationError("max_effects", expected="zero or more", received=max_effects)
    tell("reading the recordings")
    experiment = prepare(dataset)
    thresholds = Thresholds.of(experiment.noise_rms, dataset.length)
    hypothesis = Hypothesis(links=links)
    paper = replace(hypothesis, links=declared_links, placement="base", step=FINE_STEP)
    nominal = _simulated(experiment, paper)
    mended = _simulated(experiment, hypothesis.finer(FINE_LINKS, FINE_STEP))
    first: list[tuple[str, tuple[str, ...], Sequence[Array]]] = [
        ("declared model", (), nominal),
        ("finer discretisation", (), mended),
    ]
    lacking = _insufficient(experiment)
    if lacking:
        verdict = Verdict("insufficient", (), (), lacking)
        rivals = [(hypothesis, hypothesis.start * np.array(change)) for change in ((1.0, 1.0), (1.1, 1.0), (1.0, 1.3))]
        proposals = propose(experiment, rivals)
        rungs = ladder(first, thresholds.noise, seed)
        return Diagnosis(experiment, verdict, rungs, None, thresholds, tuple(nominal), None, proposals)
    tell("stiffness and damping")
    base_fit = fit(experiment, hypothesis)
    if not any(slopes.any() for slopes in base_fit.slopes):
        raise IdentificationError(
            "model", expected="an arm that can be simulated under the recorded input", received="one that fails in every trial"
        )
    base = Candidate(base_fit, tuple(leave_one_out(experiment, base_fit)))
    by_level = _by_level(experiment, base)
    with workers(experiment, jobs, advance) as crew:

        def searched(start: Candidate) -> Search:
            return search(start, candidates, thresholds, crew, max_effects=max_effects, seed=seed, tell=tell)

        found = searched(base)
        verdict = judge(structure(mended), found, thresholds, seed, by_level)
        if by_level and worth_having(base, by_level, thresholds, seed):
            if verdict.status == "parameters":
                found = Search((by_level,), found.tried)
            elif verdict.status == "unexplained":
                tell("stiffness and damping of each level")
                found = searched(by_level)
                verdict = judge(structure(mended), found, thresholds, seed)
    tell("where the gap lies")
    return Diagnosis(
        experiment,
        verdict,
        ladder([*first, *_rungs(base, found)], thresholds.noise, seed),
        found,
        thresholds,
        tuple(nominal),
        locate(experiment, base, found.best, seed),
        propose(experiment, _fitted(found, by_level, verdict.alternatives)) if verdict.status == "ambiguous" else (),
    )


def _rungs(base: Candidate, found: Search) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
    """Name, effects and held-out residuals of the fitted models on the way down."""
    rungs: list[tuple[str, tuple[str, ...], Sequence[Array]]] = [("stiffness and damping", (), base.heldout)]
    if found.path[0] is not base:
        rungs.append(("stiffness and damping of each level", (), found.path[0].heldout))
    for before, after in itertools.pairwise(found.path):
        rungs.append((" + ".join(sorted(set(after.names) - set(before.names))), after.names, after.heldout))
    return rungs


def _by_level(experiment: Experiment, base: Candidate) -> Candidate | None:
    """Without effects, a stiffness and a damping for each declared Keq; None where there is only one."""
    levels = sorted({run.trial.keq for run in experiment.runs})
    if len(levels) < 2:
        return None
    free = tuple(f"{name}@{level:g}" for level in levels for name in base.fit.hypothesis.free)
    start = np.tile(base.fit.values, len(levels))
    answer = fit(experiment, replace(base.fit.hypothesis, free=free), start=start, after=base.fit)
    return Candidate(answer, tuple(leave_one_out(experiment, answer)))


def _fitted(found: Search, by_level: Candidate | None, sets: Sequence[tuple[str, ...]]) -> list[tuple[Hypothesis, Array]]:
    """The best fit with each set of effects; without effects, that with other parameters at each level."""
    tried = [*found.tried, *([by_level] if by_level else [])]
    best = [min((c for c in tried if c.names == names), key=mean_square) for names in sets]
    return [(candidate.fit.hypothesis, candidate.fit.values) for candidate in best]


def _templates(names: Sequence[str] | None) -> list[Effect]:
    kinds = [effect_named(name) for name in names] if names is not None else list(EFFECTS.values())
    return [neutral(kind, **options) for kind in dict.fromkeys(kinds) for options in kind.variants()]


def _simulated(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    return residuals(experiment, predict(experiment, hypothesis, [(run, hypothesis.start) for run in experiment.runs]))


def _insufficient(experiment: Experiment) -> str:
    """What is lacking, and what to record; empty if nothing is."""
    moving = [run for run in experiment.runs if moves(run, experiment.noise)]
    if len(moving) < 2:
        return (
            f"In {len(moving)} of {len(experiment.runs)} usable trials the arm moves; at least two are needed to check a model "
            "on data it was not fitted to. Record steps to three or more torques, at two stiffness levels."
        )
    return ""
