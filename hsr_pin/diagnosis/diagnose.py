"""Diagnosis of a dataset: where the sim-to-real gap lies, which effects cause it, and how much each effect explains."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hsr_pin.diagnosis.indicators.indicators import indicators
from hsr_pin.diagnosis.indicators.out_of_plane import OutOfPlane
from hsr_pin.diagnosis.next_experiment import propose
from hsr_pin.diagnosis.repeatability import repeatability
from hsr_pin.diagnosis.result import Diagnosis
from hsr_pin.diagnosis.verdict import WORDS, turned_plane
from hsr_pin.diagnosis.where import Where, local_defect, locate
from hsr_pin.effects import Effect, effect_named
from hsr_pin.effects.catalogue import laws
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, informative, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.identify import simulated, split
from hsr_pin.identification.input_form import alternative_forms, best_form, form_of, with_form
from hsr_pin.identification.part import ACTING, PLAIN, SESSION, TRIALS, Part, part_variants
from hsr_pin.identification.plane import Plane, with_plane_corrected
from hsr_pin.identification.prepared import TRUEST
from hsr_pin.identification.supply import supplies
from hsr_pin.inference import Cause, Loss, Model
from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.candidate import Candidate, candidate, data_of
from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.ladder import ladder
from hsr_pin.inference.resampling import squares
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.inference.search import Search, judged, search, with_detection_limits, without
from hsr_pin.inference.verdict import Limits, Verdict, predicted_no_better, verdict_of
from hsr_pin.parallel import open_executor, prepare_workers
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import Placement
from hsr_pin.simulation.compiled import precompile
from hsr_pin.trajectory import Array, Dataset

#: Number of the most probable models that are fitted again with another interpolation of the commands.
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
        dataset: a dataset with at least two trials in which the arm moves, or its folder.
        effects: names of the candidate effects; default: the whole catalogue.
        max_effects: largest number of effects in one model.
        links: number of links of the fitted chain; default: 16, or that of the simulation that made the dataset.
        placement: joint placement of the fitted chain; default: in the middle of each element, or as in that simulation.
        declared_links: number of links of the declared model, with joints at the ends of the links as in the paper.
        delay: trials that start from a pose are used only from this time after their declared start [s].
        train: names or patterns of the trials that are fitted; default: all trials that are not held out.
        test: names or patterns of the held-out trials, which are used for the ladder; default: those not in ``train``. If there
            are none, each trial is predicted by a fit to the others.
        jobs: number of processes; default: one per core.
        cluster: address of a Dask scheduler to use instead of local processes.
        executor: executor to use instead of both.
        loss: gains and losses of a report; default: the table of :class:`Loss`.
        seed: seed of the resampling.
        tell: function that receives a progress message at each stage.
        advance: called after each fit.

    Raises:
        IdentificationError: nothing in the dataset can be compared with a model, or an argument is out of range.
        EffectError: an effect is unknown.
    """
    if not isinstance(dataset, Dataset):
        dataset = read_dataset(dataset)
    space = dataset.bending == "space"
    kinds = laws(space=space) if effects is None else [effect_named(name) for name in dict.fromkeys(effects)]
    if max_effects < 0:
        raise IdentificationError("max_effects", expected="zero or more", received=max_effects)
    tell("reading the recordings")
    whole, plane = with_plane_corrected(prepare(dataset, delay=delay))
    experiment, heldout = split(whole, train, test)
    if heldout:
        named = ", ".join(run.trial.name for run in heldout.runs)
        experiment = _noted(experiment, f"the ladder uses held-out trials, to which nothing was fitted: {named}")
    if effects is not None:
        refuse_unsupported(kinds, space=space)
    parts = catalogue(kinds, experiment, tuple(PLAIN) if effects is None else ())
    precompile(kinds, space=space)
    if executor is not None:
        prepare_workers(executor, precompile, kinds, space)
    with open_executor(jobs, cluster, executor) as executor:
        study = _Study(
            parts,
            Hypothesis(**chain_of(dataset, links, placement)),
            declared_links,
            max_effects,
            heldout,
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
    """Settings of a diagnosis; other fields are the arguments of :func:`diagnose`.

    Attributes:
        parts: the candidate effects in all variants.
        hypothesis: the model without effects.
        heldout: the held-out trials.
        plane: the plane of bending that was corrected, if any.
    """

    parts: Sequence[Part]
    hypothesis: Hypothesis
    declared_links: int
    max_effects: int
    heldout: Experiment | None
    plane: Plane | None
    executor: Executor
    loss: Loss
    seed: int
    tell: Callable[[str], None]
    advance: Callable[[], None]

    def of(self, experiment: Experiment) -> Diagnosis:
        """Return the diagnosis of recordings."""
        shown, repeated, supply = indicators(experiment), repeatability(experiment), supplies(experiment.dataset)
        shown = shown.with_indicator(OutOfPlane(self.plane)) if self.plane else shown
        experiment = replace(experiment, notes=(*experiment.notes, *shown.notes))
        length, scatter = experiment.dataset.length, repeated.floor if repeated else None
        limits = Limits.of(experiment.noise_rms, TRUEST * length)
        paper = replace(self.hypothesis, links=self.declared_links, placement="base")
        lacking = _insufficient(experiment)
        if lacking:
            start = self.hypothesis.start
            rivals = [(self.hypothesis, start * np.array(change)) for change in ((1.0, 1.0), (1.1, 1.0), (1.0, 1.3))]
            lower = ladder(self._declared(experiment, paper), limits.noise, self.seed)
            nominal = tuple(_simulated(experiment, paper))
            verdict = Verdict("insufficient", (), (), lacking)
            return Diagnosis(
                experiment, verdict, lower, None, limits, nominal, None, propose(experiment, rivals), shown, repeated, supply
            )
        self.tell("fitting stiffness and damping")
        experiment, base_fit = best_form(experiment, fit(experiment, self.hypothesis))
        experiment = _able(experiment, base_fit)
        experiment, found, located = self._searched(experiment, base_fit, limits)
        declared = lasting_square(_simulated(experiment, self.hypothesis))
        verdict = verdict_of(found, limits, declared, WORDS, length=length, scatter=scatter, loss=self.loss)
        self.tell("locating the gap")
        rungs = self._rungs(found, experiment)
        if self.heldout:
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
            shown,
            repeated,
            supply,
            self.loss,
        )

    def _searched(self, experiment: Experiment, base_fit: Fit, limits: Limits) -> tuple[Experiment, Search, Where]:
        """Return the recordings with the best interpolation of their commands, the fitted models, and the maps of the gap."""
        variants = Counter(part.name for part in self.parts)
        data, numbers = data_of(experiment), calibrated()
        pool = FitPool(experiment, self.executor, variants, self.advance)
        base = candidate(experiment, base_fit, variants)
        located = pool.submit(locate, base, self.seed)
        starts = [base, *pool.full(_by_level(experiment, base_fit))]
        gap = len(experiment.axes) * base.model.misfit
        most = self.max_effects if gap > limits.closed**2 else 0

        def searched(starts: Sequence[Candidate], pool: FitPool) -> tuple[Candidate, ...]:
            return search(starts, self.parts, pool, data, numbers, max_effects=most, tell=self.tell)

        candidates = searched(starts, pool)
        found = judged(candidates, data, numbers)
        for other in alternative_forms(experiment) if most else ():
            self.tell("trying another interpolation of the commands")
            others = FitPool(other, self.executor, variants, self.advance)
            again = others.full(_again(found))
            both = judged((*candidates, *again), data, numbers)
            if both.best in again:
                again = list(searched(again, others))
                both = judged((*candidates, *again), data, numbers)
            if both.best in again:
                experiment, pool = other, others
            candidates, found = both.candidates, both
        where = located()
        found = judged(candidates, data, numbers, unfitted(base, where))
        closed = limits.closed**2 / len(experiment.axes)
        return experiment, with_detection_limits(found, experiment, self.parts, pool, numbers, closed), where

    def _declared(self, experiment: Experiment, paper: Hypothesis) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
        """Return the first rows of the ladder: the declared model of the paper, and the same with a finer discretisation."""
        test = with_form(self.heldout, form_of(experiment)) if self.heldout else experiment
        return [
            ("declared model", (), _simulated(test, paper)),
            ("finer discretisation", (), _simulated(test, self.hypothesis)),
        ]

    def _rungs(self, found: Search, experiment: Experiment) -> list[tuple[str, tuple[str, ...], Sequence[Array]]]:
        """Return name, effects and held-out residuals of the models from the base model to the best one."""
        test = with_form(self.heldout, form_of(experiment)) if self.heldout else None

        def heldout(model: Candidate) -> Sequence[Array]:
            return model.heldout if test is None else simulated(test, model.fit.hypothesis, model.fit.values)

        path = found.path
        rungs: list[tuple[str, tuple[str, ...], Sequence[Array]]] = [("stiffness and damping", (), heldout(path[0]))]
        for before, after in itertools.pairwise(path):
            name = " + ".join(sorted(set(after.names) - set(before.names))) or "stiffness and damping of each level"
            rungs.append((name, after.names, heldout(after)))
        return rungs


def _able(experiment: Experiment, base: Fit) -> Experiment:
    """Return the recordings with a note on the trials that the base model cannot simulate.

    Raises:
        IdentificationError: no trial can be simulated.
    """
    if not any(slopes.any() for slopes in base.slopes):
        raise IdentificationError(
            "model",
            expected="an arm that can be simulated under the recorded input",
            received="one that fails in every trial",
        )
    if base.failed:
        return _noted(experiment, f"trials that cannot be simulated (check their input): {', '.join(base.failed)}")
    return experiment


def unfitted(base: Candidate, where: Where) -> list[Model]:
    """Return summaries of causes without a law that could be fitted: base motion and periodic disturbances.

    Each of them stands for its kind of physics. Its misfit is the part of the gap that it does not predict in held-out trials.
    """
    shares = {} if where.base is None else {("base_motion", "measurement"): where.base.predicted}
    if where.pulsation is not None:
        shares["pulsating_torque", "actuation_map"] = where.pulsation.added
        shares["pulsating_stiffness", "elastic"] = where.pulsation.elastic
    return [
        replace(base.model, causes=(Cause(name, kind, flexible=True),), misfits=(1 - max(share, 0.0)) * base.model.misfits)
        for (name, kind), share in shares.items()
    ]


def _again(found: Search) -> list[Fit]:
    """Return the starts for fits with another interpolation of the commands: the best models, also without their delays."""
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
    """Return the start of a fit with one stiffness and damping for each declared Keq; empty if there is only one Keq."""
    levels = sorted({run.trial.keq for run in experiment.runs})
    if len(levels) < 2:
        return []
    free = tuple(f"{name}@{level:g}" for level in levels for name in base.hypothesis.free)
    return [replace(base, hypothesis=replace(base.hypothesis, free=free), values=np.tile(base.values, len(levels)))]


def _fitted(found: Search, sets: Sequence[tuple[str, ...]]) -> list[tuple[Hypothesis, Array]]:
    """Return the best fit with each set of effects."""
    return [(each.fit.hypothesis, each.fit.values) for each in found.leaders(sets)]


def catalogue(kinds: Sequence[type[Effect]], experiment: Experiment, plain: Sequence[str] = ACTING) -> list[Part]:
    """Return all variants of some effects that these recordings can distinguish, and the model's own parameters that may be free.

    If the mass of the arm is known, no other mass along the arm is included.
    """
    parts = [Part(name) for name in plain if name not in SESSION or len(experiment.runs) >= TRIALS]
    driven, space = any(run.span > 0 or run.torque[0] != 0 for run in experiment.runs), len(experiment.directions) > 1
    levels = experiment.levels
    # several runs of each level, so that a fit without one of them still determines a size for each level
    determined = len(levels) > 1 and all(sum(run.trial.keq == keq for run in experiment.runs) > 1 for keq in levels)
    for kind in kinds:
        parts += part_variants(kind, space=space, levels=len(levels), each=levels if determined else ())
    known = {"mass_scale", "added_mass"} if experiment.dataset.weighed else set()
    return [part for part in parts if part.name not in known and (driven or part.kind not in ("actuation_time", "actuation_map"))]


def refuse_unsupported(kinds: Sequence[type[Effect]], *, space: bool) -> None:
    """Refuse requested effects that have no form for arms in space, or for arms in a plane.

    Raises:
        IdentificationError: an effect has no such form; the message names it.
    """
    if wrong := [kind.name for kind in kinds if not part_variants(kind, space=space)]:
        expected = "laws that hold about two axes" if space else "laws of an arm in a plane"
        raise IdentificationError("effects", expected=expected, received=", ".join(wrong))


def _noted(experiment: Experiment, note: str) -> Experiment:
    return replace(experiment, notes=(*experiment.notes, note))


def _simulated(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    return simulated(experiment, hypothesis, hypothesis.start)


def _insufficient(experiment: Experiment) -> str:
    """Return the reason why the recordings are insufficient and what to record; empty if they are sufficient."""
    count = len(informative(experiment))
    if count < 2:
        return (
            f"In {count} of {len(experiment.runs)} usable trials the arm moves; at least two are needed to check a model "
            "on held-out data. Record steps to three or more torques, at two stiffness levels."
        )
    return ""
