"""Where the sim-to-real gap lies, which effect causes it, how far it shrinks: from a dataset to a diagnosis."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.crew import Crew
from hsr_pin.diagnosis.evidence import structure
from hsr_pin.diagnosis.fingerprint.fingerprint import Fingerprint, fingerprint
from hsr_pin.diagnosis.fingerprint.out_of_plane import OutOfPlane
from hsr_pin.diagnosis.held_damping import HeldDamping, with_damping_held
from hsr_pin.diagnosis.ladder import Rung, ladder
from hsr_pin.diagnosis.next_experiment import Proposal, propose
from hsr_pin.diagnosis.pulsation import pulsation
from hsr_pin.diagnosis.repeats import Repeats, repeats
from hsr_pin.diagnosis.search import Search, search, without
from hsr_pin.diagnosis.support import supports
from hsr_pin.diagnosis.thresholds import Thresholds, clearly_worse, mean_square, tolerated, worth_having
from hsr_pin.diagnosis.traces import Trace, beside, if_foretold, mostly_explained, ruled_out, with_traces
from hsr_pin.diagnosis.verdict import Evidence, Verdict, judge
from hsr_pin.diagnosis.where import Where, local_defect
from hsr_pin.effects import Effect, effect_named
from hsr_pin.effects.catalogue import laws
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, moves, prepare
from hsr_pin.identification.fit import fit
from hsr_pin.identification.heldout import leave_one_out
from hsr_pin.identification.hypothesis import ACTING, LINKS, PLAIN, SESSION, TRIALS, Hypothesis, Part, readings
from hsr_pin.identification.identify import simulated, split
from hsr_pin.identification.input_form import as_it_fits, form_of, otherwise, taken
from hsr_pin.identification.plane import Plane, in_its_plane
from hsr_pin.parallel import beforehand, workers
from hsr_pin.simulation.compiled import ready
from hsr_pin.trajectory import Array, Dataset

#: Open commands are taken another way only where this leaves stiffness and damping alone at most so many times the error.
FORM = 1.5


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
        fingerprint: what the recordings show without a model.
        repeats: how far the arm is from itself; None where no trials repeat one another.
        held: the best model with the damping as declared; None where that is no other reading of it, or no torque is slow.
    """

    experiment: Experiment
    verdict: Verdict
    ladder: tuple[Rung, ...]
    search: Search | None
    thresholds: Thresholds
    nominal: tuple[Array, ...]
    where: Where | None = None
    next_experiment: tuple[Proposal, ...] = ()
    fingerprint: Fingerprint | None = None
    repeats: Repeats | None = None
    held: HeldDamping | None = None


def diagnose(
    dataset: Dataset,
    *,
    effects: Sequence[str] | None = None,
    max_effects: int = 3,
    links: int = LINKS,
    declared_links: int = 4,
    delay: float = 0.0,
    train: Sequence[str] = (),
    test: Sequence[str] = (),
    jobs: int | None = None,
    cluster: str | None = None,
    executor: Executor | None = None,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
    advance: Callable[[], None] = lambda: None,
) -> Diagnosis:
    """Diagnose the sim-to-real gap of a dataset.

    Args:
        dataset: at least two trials in which the arm moves.
        effects: names of the candidates; default: the whole catalogue.
        max_effects: at most this many together.
        links: of the chain that is fitted.
        declared_links: of the declared model, with joints at the links' ends as in the paper.
        delay: trials that start from a pose are followed only from so long after their declared start [s].
        train: names or patterns of the trials that the evidence comes from; default: all that are not set aside.
        test: of the trials set aside, on which the ladder is told; default: those not among ``train``. Without any, each trial is
            predicted by a fit to the others.
        jobs: processes; default: one per core.
        cluster: address of a Dask scheduler whose workers do it instead.
        executor: in place of both.
        seed: of the resampling.
        tell: called with a line at each stage.
        advance: called after each fit.

    Raises:
        IdentificationError: nothing in the dataset can be compared with a model, or an argument is out of range.
        EffectError: an unknown effect.
    """
    space = dataset.bending == "space"
    kinds = laws(space=space) if effects is None else [effect_named(name) for name in dict.fromkeys(effects)]
    if max_effects < 0:
        raise IdentificationError("max_effects", expected="zero or more", received=max_effects)
    tell("reading the recordings")
    whole, plane = in_its_plane(prepare(dataset, delay=delay))
    experiment, aside = split(whole, train, test)
    if aside:
        told = ", ".join(run.trial.name for run in aside.runs)
        experiment = _noted(experiment, f"the ladder is told on trials to which nothing was fitted: {told}")
    if effects is not None:
        refuse_formless(kinds, space=space)
    parts = catalogue(kinds, experiment, tuple(PLAIN) if effects is None else ())
    ready(kinds, space=space)
    if executor is not None:
        beforehand(executor, ready, kinds, space)
    with workers(jobs, cluster, executor) as executor:
        study = _Study(parts, Hypothesis(links=links), declared_links, max_effects, aside, plane, executor, seed, tell, advance)
        found = study.of(experiment)
        other, needless = study.turned(found)
        if other is None:
            return study.in_other_forms(found)
        tell("the commands taken the other way")
        again = study.of(other, settled=True)
    one, two = (each.search.best if each.search else None for each in (found, again))
    kept = one and two and not needless and clearly_worse(two, one, found.thresholds, seed)
    return found if kept else again


@dataclass(frozen=True, eq=False)
class _Study:
    """How recordings are diagnosed: arguments as of :func:`diagnose`.

    Attributes:
        parts: the candidates.
        hypothesis: the arm alone.
        aside: the trials set aside.
        plane: that was turned back.
    """

    parts: Sequence[Part]
    hypothesis: Hypothesis
    declared_links: int
    max_effects: int
    aside: Experiment | None
    plane: Plane | None
    executor: Executor
    seed: int
    tell: Callable[[str], None]
    advance: Callable[[], None]

    def of(self, experiment: Experiment, *, settled: bool = False) -> Diagnosis:
        """The diagnosis; unless it is ``settled`` with open commands as they fit the arm alone best."""
        seed, tell, hypothesis, lacking = self.seed, self.tell, self.hypothesis, _insufficient(experiment)
        if not lacking:
            tell("stiffness and damping")
            base_fit = fit(experiment, hypothesis)
            experiment, base_fit = (experiment, base_fit) if settled else as_it_fits(experiment, base_fit)
        aside = taken(self.aside, form_of(experiment)) if self.aside else None
        prints, own = fingerprint(experiment), repeats(experiment)
        prints = prints.with_print(OutOfPlane(self.plane)) if self.plane else prints
        experiment = replace(experiment, notes=(*experiment.notes, *prints.notes))
        length, itself = experiment.dataset.length, own.floor if own else None
        thresholds = Thresholds.of(experiment.noise_rms, length, itself)
        paper = replace(hypothesis, links=self.declared_links, placement="base")
        nominal = _simulated(experiment, paper)
        mended = _simulated(experiment, hypothesis)
        first: list[tuple[str, tuple[str, ...], Sequence[Array]]] = [
            ("declared model", (), _simulated(aside, paper) if aside else nominal),
            ("finer discretisation", (), _simulated(aside, hypothesis) if aside else mended),
        ]
        if lacking:
            verdict = Verdict("insufficient", (), (), lacking)
            rivals = [(hypothesis, hypothesis.start * np.array(change)) for change in ((1.0, 1.0), (1.1, 1.0), (1.0, 1.3))]
            proposals = propose(experiment, rivals)
            lower = ladder(first, thresholds.noise, seed)
            return Diagnosis(experiment, verdict, lower, None, thresholds, tuple(nominal), None, proposals, prints, own)
        if not any(slopes.any() for slopes in base_fit.slopes):
            raise IdentificationError(
                "model",
                expected="an arm that can be simulated under the recorded input",
                received="one that fails in every trial",
            )
        if base_fit.failed:
            experiment = _noted(experiment, f"cannot be simulated, is the input right? {', '.join(base_fit.failed)}")
        base = Candidate(base_fit, tuple(leave_one_out(experiment, base_fit)))
        by_level = _by_level(experiment, base)
        crew = Crew(experiment, self.executor, self.advance)
        located = crew.where(base, seed)

        def searched(start: Candidate) -> Search:
            return search(start, self.parts, thresholds, crew, max_effects=self.max_effects, seed=seed, tell=tell)

        def judged(found: Search, by_level: Candidate | None) -> Verdict:
            told = supports(experiment, found.best, found.path[0], found.tried, thresholds, seed, prints.kinds)
            evidence = Evidence(structure(mended), *told, length, itself, by_level, seed)
            return judge(found, thresholds, evidence)

        found = searched(base)
        verdict = judged(found, by_level)
        if by_level and worth_having(base, by_level, thresholds, seed):
            if verdict.status == "parameters" and not verdict.support:
                found = Search((by_level,), found.tried)
            elif verdict.status == "unexplained":
                tell("stiffness and damping of each level")
                found = searched(by_level)
                verdict = judged(found, None)
        tell("where the gap lies")
        where = replace(located(), defect=local_defect(found.best))
        before, verdict = verdict, ruled_out(verdict, where.spread, self.parts, thresholds)
        explained = verdict is before and mostly_explained(found, thresholds)
        looks: tuple[Callable[[], Trace | None], ...] = (
            lambda: where.base,
            lambda: where.spread if not explained else None,
            lambda: pulsation(experiment, base_fit, seed),
        )
        rungs, told = _rungs(base, found, aside), verdict
        if aside:
            told = if_foretold(verdict, rungs[0][2], rungs[-1][2], found.best.names)
        verdict = beside(told if told is not verdict else with_traces(verdict, (look() for look in looks)), self.plane)
        return Diagnosis(
            experiment,
            verdict,
            ladder([*first, *rungs], thresholds.noise, seed, itself),
            found,
            thresholds,
            tuple(nominal),
            where,
            propose(experiment, _fitted(found, by_level, verdict.alternatives)) if verdict.status == "ambiguous" else (),
            prints,
            own,
            with_damping_held(base, found.best, crew) if "actuation_time" in verdict.kinds else None,
        )

    def turned(self, found: Diagnosis) -> tuple[Experiment | None, bool]:
        """The recordings with open commands taken the other way, where that fits better, or as well with less; and whether this.

        Without the lag that an arm has, a command that goes straight from sample to sample looks like one that is held. And
        where a held one is taken to go straight, half a sample earlier, the arm seems to be late.
        """
        if found.search is None:
            return None, False
        best, late = found.search.best, [each for each in found.search.tried if "actuation_time" in each.kinds]
        if not best.names:  # a pair of which neither is worth having takes up noise
            late = [each for each in late if len(each.names) == 1]
        likely = {id(each): each.fit for each in (best, *sorted(late, key=mean_square)[:1])}
        crews = [(other, Crew(other, self.executor, self.advance)) for other in otherwise(found.experiment)]
        again = [(other, each) for other, crew in crews for each in crew.finish(list(likely.values()))]
        for other, better in sorted(again, key=lambda each: mean_square(each[1]))[:1]:
            if worth_having(best, better, found.thresholds, self.seed):
                return other, False
        simpler = [(other, each) for other, crew in crews for each in self._sooner(best, crew)]
        return next((other for other, each in simpler if self.needless(best, each, found.thresholds)), None), True

    def in_other_forms(self, found: Diagnosis) -> Diagnosis:
        """Of recordings that nothing explains, what explains them with open commands taken another way, where something does.

        Which way fits the arm alone best need not be so: an arm with play may fit better where commands come too early. Nothing
        that is late is taken from there, for the way itself may make it so.
        """
        if found.verdict.status != "unexplained" or found.search is None:
            return found
        base, best = found.search.path[0], found.search.best
        for other in otherwise(found.experiment):
            alone = fit(other, base.fit.hypothesis, start=base.fit.values)
            if alone.rms > FORM * base.fit.rms:
                continue
            self.tell("the commands taken the other way")
            again = self.of(other, settled=True)
            told = again.search.best if again.search and again.verdict.status != "unexplained" else None
            if told and "actuation_time" not in told.kinds and clearly_worse(best, told, found.thresholds, self.seed):
                return again
        return found

    def needless(self, best: Candidate, other: Candidate, thresholds: Thresholds) -> bool:
        """Whether what a model has is not needed, by another of the commands taken the other way.

        A law less is enough where that law would not be worth having there; a simpler law, where it is no worse by anything that
        counts, certain or not.
        """
        if len(other.names) < len(best.names):
            return not worth_having(other, best, thresholds, self.seed)
        return mean_square(other) - mean_square(best) <= tolerated(best, thresholds)

    def _sooner(self, best: Candidate, crew: Crew) -> list[Candidate]:
        """A model without what makes it late, or with a simpler law of that in its place."""
        models: list[Candidate] = []
        for part in best.fit.hypothesis.parts:
            if part.kind != "actuation_time":
                continue
            base = crew.finish([without(best.fit, part.name)])[0]
            guesses = crew.guess(base, [other for other in self.parts if part.contains(other)])
            models += [base, *crew.finish(crew.glance([(base.fit, guess) for guess in guesses]))]
        return models


def _rungs(base: Candidate, found: Search, aside: Experiment | None) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
    """Name, effects and held-out residuals of the fitted models on the way down: on the trials set aside, if there are any."""

    def heldout(model: Candidate) -> Sequence[Array]:
        return model.heldout if aside is None else simulated(aside, model.fit.hypothesis, model.fit.values)

    rungs: list[tuple[str, tuple[str, ...], Sequence[Array]]] = [("stiffness and damping", (), heldout(base))]
    if found.path[0] is not base:
        rungs.append(("stiffness and damping of each level", (), heldout(found.path[0])))
    for before, after in itertools.pairwise(found.path):
        rungs.append((" + ".join(sorted(set(after.names) - set(before.names))), after.names, heldout(after)))
    return rungs


def _by_level(experiment: Experiment, base: Candidate) -> Candidate | None:
    """Without effects, a stiffness and a damping for each declared Keq; None where there is only one."""
    levels = sorted({run.trial.keq for run in experiment.runs})
    if len(levels) < 2:
        return None
    free = tuple(f"{name}@{level:g}" for level in levels for name in base.fit.hypothesis.free)
    start = np.tile(base.fit.values, len(levels))
    answer = fit(experiment, replace(base.fit.hypothesis, free=free), start=start)
    return Candidate(answer, tuple(leave_one_out(experiment, answer)))


def _fitted(found: Search, by_level: Candidate | None, sets: Sequence[tuple[str, ...]]) -> list[tuple[Hypothesis, Array]]:
    """The best fit with each set of effects; without effects, that with other parameters at each level."""
    tried = [*found.tried, *([by_level] if by_level else [])]
    best = [min((c for c in tried if c.names == names), key=mean_square) for names in sets]
    return [(candidate.fit.hypothesis, candidate.fit.values) for candidate in best]


def catalogue(kinds: Sequence[type[Effect]], experiment: Experiment, plain: Sequence[str] = ACTING) -> list[Part]:
    """Every reading of some effects that these recordings could tell apart, and the arm's numbers that may be open."""
    parts = [Part(name) for name in plain if name not in SESSION or len(experiment.runs) >= TRIALS]
    driven, space = any(run.span > 0 or run.torque[0] != 0 for run in experiment.runs), len(experiment.directions) > 1
    levels = experiment.levels
    told = len(levels) > 1 and all(sum(run.trial.keq == keq for run in experiment.runs) > 1 for keq in levels)  # held out, too
    for kind in kinds:
        parts += readings(kind, space=space, levels=len(levels), each=levels if told else ())
    return [part for part in parts if driven or part.kind not in ("actuation_time", "actuation_map")]


def refuse_formless(kinds: Sequence[type[Effect]], *, space: bool) -> None:
    """Refuse effects that were asked for and have no form for arms in space, or for those in a plane.

    Raises:
        IdentificationError: naming them.
    """
    if wrong := [kind.name for kind in kinds if not readings(kind, space=space)]:
        expected = "laws that hold about two axes" if space else "laws of an arm in a plane"
        raise IdentificationError("effects", expected=expected, received=", ".join(wrong))


def _noted(experiment: Experiment, note: str) -> Experiment:
    return replace(experiment, notes=(*experiment.notes, note))


def _simulated(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    return simulated(experiment, hypothesis, hypothesis.start)


def _insufficient(experiment: Experiment) -> str:
    """What is lacking, and what to record; empty if nothing is."""
    moving = [run for run in experiment.runs if moves(run, experiment.noise)]
    if len(moving) < 2:
        return (
            f"In {len(moving)} of {len(experiment.runs)} usable trials the arm moves; at least two are needed to check a model "
            "on data it was not fitted to. Record steps to three or more torques, at two stiffness levels."
        )
    return ""
