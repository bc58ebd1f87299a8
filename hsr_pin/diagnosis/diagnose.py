"""Where the sim-to-real gap lies, which effect causes it, how far it shrinks: from a dataset to a diagnosis."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hsr_pin.diagnosis.fingerprint.fingerprint import fingerprint
from hsr_pin.diagnosis.fingerprint.out_of_plane import OutOfPlane
from hsr_pin.diagnosis.next_experiment import propose
from hsr_pin.diagnosis.repeats import repeats
from hsr_pin.diagnosis.result import Diagnosis
from hsr_pin.diagnosis.verdict import WORDS, turned_plane
from hsr_pin.diagnosis.where import Where, local_defect, locate
from hsr_pin.effects import Effect, effect_named
from hsr_pin.effects.catalogue import laws
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, moves, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.identify import simulated, split
from hsr_pin.identification.input_form import as_it_fits, form_of, otherwise, taken
from hsr_pin.identification.part import ACTING, PLAIN, SESSION, TRIALS, Part, readings
from hsr_pin.identification.plane import Plane, in_its_plane
from hsr_pin.identification.prepared import TRUEST
from hsr_pin.inference import Cause, Loss, Model
from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.candidate import Candidate, candidate, data_of
from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.ladder import ladder
from hsr_pin.inference.resampling import squares
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.inference.search import Search, judged, search, without
from hsr_pin.inference.verdict import Limits, Verdict, predicted_no_better, verdict_of
from hsr_pin.parallel import beforehand, workers
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import Placement
from hsr_pin.simulation.compiled import ready
from hsr_pin.trajectory import Array, Dataset

#: Models that are fitted again where commands may be taken another way: the most probable few.
_AGAIN = 3


def diagnose(
    dataset: Dataset | str | Path,
    *,
    effects: Sequence[str] | None = None,
    max_effects: int = 3,
    links: int | None = None,
    placement: Placement | None = None,
    declared_links: int = 4,
    delay: float = 0.0,
    train: Sequence[str] = (),
    test: Sequence[str] = (),
    jobs: int | None = None,
    cluster: str | None = None,
    executor: Executor | None = None,
    loss: Loss | None = None,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
    advance: Callable[[], None] = lambda: None,
) -> Diagnosis:
    """Diagnose the sim-to-real gap of a dataset.

    Args:
        dataset: at least two trials in which the arm moves; or the folder that holds it.
        effects: names of the candidates; default: the whole catalogue.
        max_effects: at most this many together.
        links: of the chain that is fitted; default: 16, or as many as simulated the dataset.
        placement: of its joints; default: in the middle of each element, or as in the simulation.
        declared_links: of the declared model, with joints at the links' ends as in the paper.
        delay: trials that start from a pose are followed only from so long after their declared start [s].
        train: names or patterns of the trials that the evidence comes from; default: all that are not set aside.
        test: of the trials set aside, on which the ladder is told; default: those not among ``train``. Without any, each trial is
            predicted by a fit to the others.
        jobs: processes; default: one per core.
        cluster: address of a Dask scheduler whose workers do it instead.
        executor: in place of both.
        loss: what each report gains where it is right and loses where it is not; default: the table of :class:`Loss`.
        seed: of the resampling.
        tell: called with a line at each stage.
        advance: called after each fit.

    Raises:
        IdentificationError: nothing in the dataset can be compared with a model, or an argument is out of range.
        EffectError: an unknown effect.
    """
    if not isinstance(dataset, Dataset):
        dataset = read_dataset(dataset)
    space = dataset.bending == "space"
    kinds = laws(space=space) if effects is None else [effect_named(name) for name in dict.fromkeys(effects)]
    if max_effects < 0:
        raise IdentificationError("max_effects", expected="zero or more", received=max_effects)
    tell("reading the recordings")
    whole, plane = in_its_plane(prepare(dataset, delay=delay))
    experiment, aside = split(whole, train, test)
    if aside:
        named = ", ".join(run.trial.name for run in aside.runs)
        experiment = _noted(experiment, f"the ladder uses trials to which nothing was fitted: {named}")
    if effects is not None:
        refuse_formless(kinds, space=space)
    parts = catalogue(kinds, experiment, tuple(PLAIN) if effects is None else ())
    ready(kinds, space=space)
    if executor is not None:
        beforehand(executor, ready, kinds, space)
    with workers(jobs, cluster, executor) as executor:
        study = _Study(
            parts,
            Hypothesis(**chain_of(dataset, links, placement)),
            declared_links,
            max_effects,
            aside,
            plane,
            executor,
            loss or Loss(),
            seed,
            tell,
            advance,
        )
        return study.of(experiment)


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
    loss: Loss
    seed: int
    tell: Callable[[str], None]
    advance: Callable[[], None]

    def of(self, experiment: Experiment) -> Diagnosis:
        """The diagnosis."""
        prints, own = fingerprint(experiment), repeats(experiment)
        prints = prints.with_print(OutOfPlane(self.plane)) if self.plane else prints
        experiment = replace(experiment, notes=(*experiment.notes, *prints.notes))
        length, scatter = experiment.dataset.length, own.floor if own else None
        limits = Limits.of(experiment.noise_rms, TRUEST * length)
        paper = replace(self.hypothesis, links=self.declared_links, placement="base")
        lacking = _insufficient(experiment)
        if lacking:
            start = self.hypothesis.start
            rivals = [(self.hypothesis, start * np.array(change)) for change in ((1.0, 1.0), (1.1, 1.0), (1.0, 1.3))]
            lower = ladder(self._declared(experiment, paper), limits.noise, self.seed)
            nominal = tuple(_simulated(experiment, paper))
            verdict = Verdict("insufficient", (), (), lacking)
            return Diagnosis(experiment, verdict, lower, None, limits, nominal, None, propose(experiment, rivals), prints, own)
        self.tell("stiffness and damping")
        experiment, base_fit = as_it_fits(experiment, fit(experiment, self.hypothesis))
        experiment = _able(experiment, base_fit)
        experiment, found, located = self._searched(experiment, base_fit, limits)
        declared = lasting_square(_simulated(experiment, self.hypothesis))
        verdict = verdict_of(found, limits, declared, WORDS, length=length, scatter=scatter, loss=self.loss)
        self.tell("where the gap lies")
        rungs = self._rungs(found, experiment)
        if self.aside:
            alone, best = (squares(rungs[k][2]).mean ** 0.5 for k in (0, -1))
            verdict = predicted_no_better(verdict, alone, best, found.best.names, WORDS)
        verdict = turned_plane(verdict, self.plane)
        where = replace(located, defect=local_defect(found.best))
        return Diagnosis(
            experiment,
            verdict,
            ladder([*self._declared(experiment, paper), *rungs], limits.noise, self.seed, scatter),
            found,
            limits,
            tuple(_simulated(experiment, paper)),
            where,
            propose(experiment, _fitted(found, verdict.alternatives)) if verdict.status == "ambiguous" else (),
            prints,
            own,
            self.loss,
        )

    def _searched(self, experiment: Experiment, base_fit: Fit, limits: Limits) -> tuple[Experiment, Search, Where]:
        """The recordings with open commands as the best model takes them, the models that were fitted, and where the gap lies."""
        variants = Counter(part.name for part in self.parts)
        data, numbers = data_of(experiment), calibrated()
        pool = FitPool(experiment, self.executor, variants, self.advance)
        base = candidate(experiment, base_fit, variants)
        located = pool.beside(locate, base, self.seed)
        starts = [base, *pool.full(_by_level(experiment, base_fit))]
        gap = len(experiment.axes) * base.model.misfit
        most = self.max_effects if gap > limits.closed**2 else 0

        def searched(starts: Sequence[Candidate], pool: FitPool) -> tuple[Candidate, ...]:
            return search(starts, self.parts, pool, data, numbers, max_effects=most, tell=self.tell)

        candidates = searched(starts, pool)
        found = judged(candidates, data, numbers)
        for other in otherwise(experiment) if most else ():
            self.tell("the commands taken another way")
            others = FitPool(other, self.executor, variants, self.advance)
            again = others.full(_again(found))
            both = judged((*candidates, *again), data, numbers)
            if both.best in again:
                again = list(searched(again, others))
                both = judged((*candidates, *again), data, numbers)
            if both.best in again:
                experiment = other
            candidates, found = both.candidates, both
        where = located()
        return experiment, judged(candidates, data, numbers, unfitted(base, where)), where

    def _declared(self, experiment: Experiment, paper: Hypothesis) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
        """The upper rows of the ladder: the declared model as in the paper, and finely discretised."""
        aside = taken(self.aside, form_of(experiment)) if self.aside else experiment
        return [
            ("declared model", (), _simulated(aside, paper)),
            ("finer discretisation", (), _simulated(aside, self.hypothesis)),
        ]

    def _rungs(self, found: Search, experiment: Experiment) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
        """Name, effects and held-out residuals of the models on the way to the best; on the trials set aside, if any."""
        aside = taken(self.aside, form_of(experiment)) if self.aside else None

        def heldout(model: Candidate) -> Sequence[Array]:
            return model.heldout if aside is None else simulated(aside, model.fit.hypothesis, model.fit.values)

        path = found.path
        rungs: list[tuple[str, tuple[str, ...], Sequence[Array]]] = [("stiffness and damping", (), heldout(path[0]))]
        for before, after in itertools.pairwise(path):
            name = " + ".join(sorted(set(after.names) - set(before.names))) or "stiffness and damping of each level"
            rungs.append((name, after.names, heldout(after)))
        return rungs


def _able(experiment: Experiment, base: Fit) -> Experiment:
    """The recordings, with a note on those that the arm alone cannot be simulated in.

    Raises:
        IdentificationError: it can be simulated in none.
    """
    if not any(slopes.any() for slopes in base.slopes):
        raise IdentificationError(
            "model",
            expected="an arm that can be simulated under the recorded input",
            received="one that fails in every trial",
        )
    if base.failed:
        return _noted(experiment, f"cannot be simulated, is the input right? {', '.join(base.failed)}")
    return experiment


def unfitted(base: Candidate, where: Where) -> list[Model]:
    """Causes that show without a law that could be fitted: a base that moves, and what pulsates by a clock of its own.

    Each stands for its kind and leaves what it does not predict of the gap, in trials from which it was not learnt.
    """
    shares = {} if where.base is None else {("base_motion", "measurement"): where.base.foretold}
    if where.pulsation is not None:
        shares["pulsating_torque", "actuation_map"] = where.pulsation.added
        shares["pulsating_stiffness", "elastic"] = where.pulsation.elastic
    return [
        replace(base.model, causes=(Cause(name, kind, flexible=True),), misfit=(1 - max(share, 0.0)) * base.model.misfit)
        for (name, kind), share in shares.items()
    ]


def _again(found: Search) -> list[Fit]:
    """Where to start the most probable models with the commands taken another way, and these without what makes them late."""
    leaders = found.leaders(list(found.posterior.sets)[:_AGAIN])
    models: dict[object, Fit] = {found.base.key: found.base.fit}
    for each in leaders:
        models.setdefault(each.key, each.fit)
        for part in each.fit.hypothesis.parts:
            if part.kind == "actuation_time":
                fewer = without(each.fit, part.name)
                models.setdefault(fewer.hypothesis.key, fewer)
    return list(models.values())


def _by_level(experiment: Experiment, base: Fit) -> list[Fit]:
    """Where to start a stiffness and a damping for each declared Keq; nothing where there is only one."""
    levels = sorted({run.trial.keq for run in experiment.runs})
    if len(levels) < 2:
        return []
    free = tuple(f"{name}@{level:g}" for level in levels for name in base.hypothesis.free)
    return [replace(base, hypothesis=replace(base.hypothesis, free=free), values=np.tile(base.values, len(levels)))]


def _fitted(found: Search, sets: Sequence[tuple[str, ...]]) -> list[tuple[Hypothesis, Array]]:
    """The best fit with each set of effects."""
    return [(each.fit.hypothesis, each.fit.values) for each in found.leaders(sets)]


def catalogue(kinds: Sequence[type[Effect]], experiment: Experiment, plain: Sequence[str] = ACTING) -> list[Part]:
    """Every variant of some effects that these recordings could tell apart, and the arm's numbers that may be open.

    Of an arm that was weighed no other mass along the arm is among them.
    """
    parts = [Part(name) for name in plain if name not in SESSION or len(experiment.runs) >= TRIALS]
    driven, space = any(run.span > 0 or run.torque[0] != 0 for run in experiment.runs), len(experiment.directions) > 1
    levels = experiment.levels
    told = len(levels) > 1 and all(sum(run.trial.keq == keq for run in experiment.runs) > 1 for keq in levels)  # held out, too
    for kind in kinds:
        parts += readings(kind, space=space, levels=len(levels), each=levels if told else ())
    known = {"mass_scale", "added_mass"} if experiment.dataset.weighed else set()
    return [part for part in parts if part.name not in known and (driven or part.kind not in ("actuation_time", "actuation_map"))]


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
