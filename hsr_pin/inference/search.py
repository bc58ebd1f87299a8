"""Search over models: which models to fit, until no other model could enter the credible set.

One step expands a model: the model is probed with every part that it lacks, the most promising parts get a quick fit, and the
best quick fits a full fit. Models are ranked by their evidence. The sub-models of the best model are expanded too, so that each
of its causes is compared with all alternatives. Finally, other variants and special cases of the laws in the most credible models
are fitted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import log

import numpy as np

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.candidate import Candidate, Key
from hsr_pin.inference.detection import DetectionLimit, detection_limits, parts_for_limits
from hsr_pin.inference.evidence import explained, likelihood, log_evidence, reachable
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.model import Data, Model
from hsr_pin.inference.posterior import Posterior, posterior
from hsr_pin.inference.problem import Part, Problem
from hsr_pin.inference.proposals import Proposal
from hsr_pin.inference.residuals import lasting_squares
from hsr_pin.inference.screening import from_one_basin, laws_first, screened

#: A model is credible if the best model is at most this many times as probable, in the search; probability of the credible sets.
_ODDS, _CREDIBLE = 20.0, 0.95
#: Largest number of models with the same number of causes that are expanded in one step.
_BEAM = 3
#: Least and largest number of full fits in a step.
_LEAST, _MOST = 3, 6
#: Tolerance of the log evidence of a quick fit compared with that of a full fit [nats].
_ROUGH = 5.0
#: Number of other variants and special cases that get a full fit, for each law of a credible model.
_SIBLINGS = 2


@dataclass(frozen=True, eq=False)
class Search:
    """Result of a search.

    Attributes:
        candidates: all fitted models, the model without causes first.
        posterior: posterior over the fitted models, in their order, followed by models that were not fitted here.
        data: noise variance and number of coordinates of the recordings.
        detection: sizes from which on causes that no credible model has would have been found; empty if they were not computed.
    """

    candidates: tuple[Candidate, ...]
    posterior: Posterior
    data: Data
    detection: tuple[DetectionLimit, ...] = ()

    @property
    def base(self) -> Candidate:
        """The model without causes."""
        return self.candidates[0]

    @property
    def best(self) -> Candidate:
        """The most probable model."""
        return self.candidates[int(np.argmax(self.posterior.probabilities[: len(self.candidates)]))]

    def leader(self, names: tuple[str, ...]) -> Candidate:
        """Return the most probable model with exactly these causes.

        Raises:
            KeyError: no model with these causes was fitted.
        """
        return {id(each.model): each for each in self.candidates}[id(self.posterior.leader(names))]

    def leaders(self, sets: Iterable[tuple[str, ...]]) -> list[Candidate]:
        """Return the most probable model of each set of causes for which a model was fitted."""
        fitted = {each.names for each in self.candidates}
        return [self.leader(names) for names in sets if names in fitted]

    @property
    def path(self) -> tuple[Candidate, ...]:
        """Models from the one without causes to the best, through the best sub-models of the best model."""
        path = [self.best]
        while len(path[0].names) > 1:
            inside = [each for each in self.candidates if each.names and set(each.names) < set(path[0].names)]
            if not inside:
                break
            largest = max(len(each.names) for each in inside)
            path.insert(0, min((each for each in inside if len(each.names) == largest), key=lambda each: each.heldout_square))
        if self.best is self.base:
            return (self.base,)
        return (self.base, *path)


@dataclass(eq=False)
class _State:
    """State of a search, the only mutable object in this module."""

    data: Data
    calibration: Calibration
    fitted: dict[Key, Candidate] = field(default_factory=dict)
    proposed: dict[tuple[Key, tuple[object, ...]], Proposal] = field(default_factory=dict)
    expanded: set[Key] = field(default_factory=set)
    varied: set[Key] = field(default_factory=set)

    def add(self, candidates: Sequence[Candidate]) -> None:
        """Store the candidates; of two fits of one model the one with the larger evidence is kept."""
        for each in candidates:
            known = self.fitted.get(each.key)
            if known is None or self.evidence(each) > self.evidence(known):
                self.fitted[each.key] = each

    def propose(self, asked: Sequence[tuple[Candidate, Sequence[Part]]], pool: FitPool) -> list[list[Proposal]]:
        """Return the proposals for adding parts to models; each proposal is computed once."""
        open_ = [(base, [p for p in parts if (base.key, p.variant) not in self.proposed]) for base, parts in asked]
        new = [each for each in open_ if each[1]]
        for (base, parts), found in zip(new, pool.propose(new), strict=True):
            made = {each.hypothesis.parts[-1].variant: each for each in found}
            self.proposed |= {(base.key, part.variant): made[part.variant] for part in parts if part.variant in made}
        return [[self.proposed[key] for p in parts if (key := (base.key, p.variant)) in self.proposed] for base, parts in asked]

    def evidence(self, candidate: Candidate) -> float:
        return log_evidence(candidate.model, self.data, self.calibration)

    @property
    def ranked(self) -> list[Candidate]:
        """All fitted models, the largest evidence first."""
        return sorted(self.fitted.values(), key=lambda each: -self.evidence(each))

    @property
    def least(self) -> float:
        """The log evidence that a model needs to be credible [nats]."""
        return self.evidence(self.ranked[0]) - log(_ODDS)

    def is_credible(self, candidate: Candidate) -> bool:
        """Return whether a model may be the best, and each of its causes improves the evidence enough."""
        own = self.evidence(candidate)
        parts = [self.evidence(each) for each in self.fitted.values() if set(each.names) < set(candidate.names)]
        return own >= max([self.least, *(part - self.calibration.cause for part in parts)])

    def can_grow(self, candidate: Candidate) -> bool:
        """Return whether an additional cause could improve a model enough to change the posterior."""
        nominal = max((each.model for each in self.fitted.values() if not each.names), key=lambda model: model.misfit)
        whole = replace(nominal, misfits=0 * nominal.misfits)
        shares = [explained(each, nominal, self.data, self.calibration) for each in (candidate.model, whole)]
        noticed = shares[0] < (1 - self.calibration.share) * shares[1]
        return noticed and reachable(candidate.model, self.data, self.calibration) >= self.least


def search(
    starts: Sequence[Candidate],
    parts: Sequence[Part],
    pool: FitPool,
    data: Data,
    calibration: Calibration,
    *,
    max_effects: int = 3,
    tell: Callable[[str], None] = lambda line: None,
) -> tuple[Candidate, ...]:
    """Fit every model that may be credible, and return all fitted models.

    Args:
        starts: models that are already fitted, the one without causes first.
        parts: the catalogue with every variant of each cause.
        pool: pool that runs the fits.
        data: noise variance and number of coordinates of the recordings.
        calibration: constants of the model evidence.
        max_effects: largest number of causes in a model.
        tell: function that receives a progress message at each step.
    """
    state = _State(data, calibration)
    state.add(starts)
    while True:
        if targets := _targets(state, max_effects):
            tell(_described(targets, parts))
            state.expanded |= {each.key for each in targets}
            state.add(_expanded(targets, parts, pool, state))
        elif relatives := _relatives(state):
            tell("trying other variants and special cases of the credible laws")
            state.varied |= {each.key for each in relatives}
            state.add(_varied(relatives, parts, pool, state))
        else:
            return tuple(state.fitted.values())
        state.add(_parts_of_best(pool, state))


def judged(candidates: Sequence[Candidate], data: Data, calibration: Calibration, unfitted: Sequence[Model] = ()) -> Search:
    """Return the posterior over fitted models and over models of which only the summary is known."""
    of_model = {id(each.model): each for each in candidates}

    def special_case(one: Model, other: Model) -> bool:
        fitted = id(one) in of_model and id(other) in of_model
        return fitted and of_model[id(one)].special_case_of(of_model[id(other)])

    models = [*(each.model for each in candidates), *unfitted]
    return Search(tuple(candidates), posterior(models, data, calibration, special_case), data)


def with_detection_limits(
    found: Search, problem: Problem, parts: Sequence[Part], pool: FitPool, calibration: Calibration, closed: float
) -> Search:
    """Return the result of a search with the detection limits of the causes that no credible model has.

    No cause is sought for a gap whose mean square of one coordinate is below ``closed``.
    """
    left, nominal = found.best.model.misfit, max(each.model.misfit for each in found.candidates if not each.names)
    share = calibration.share / (1 - calibration.share) * (nominal - left)
    least = max(share, 0.0 if found.best.names else closed - left)
    credible = {name for names in found.posterior.credible(_CREDIBLE) for name in names}
    asked = parts_for_limits(parts, {*credible, *found.best.names})
    (proposals,) = pool.propose([(found.best, asked)])
    return replace(found, detection=detection_limits(problem, found.best, asked, proposals, found.data, calibration, least))


def without(fit: Fit, name: str) -> Fit:
    """Return the start of the fit of a model without one of its parts."""
    fewer, kept = fit.hypothesis.without_part(name)
    return replace(fit, hypothesis=fewer, values=fit.values[kept])


def _described(targets: Sequence[Candidate], parts: Sequence[Part]) -> str:
    models = f"in addition to {' + '.join(targets[0].names) if len(targets) == 1 else f'each of {len(targets)} models'}"
    return f"trying {len(parts)} laws" + (f" {models}" if targets[0].names else "")


def _targets(state: _State, max_effects: int) -> list[Candidate]:
    """Return the models to expand next: the smallest of the most credible models, and the sub-models of the best one."""
    ranked = state.ranked
    best, base = ranked[0], next(iter(state.fitted.values()))
    for size in range(max_effects):
        own = [each for each in ranked if len(each.names) == size and each.names]
        credible = [each for each in own if state.is_credible(each)]
        parts = [each for each in own if set(each.names) < set(best.names)]
        asked = {each.key: each for each in (*credible[:_BEAM], *parts)} if size else {base.key: base}
        chosen = [each for each in asked.values() if each.key not in state.expanded and state.can_grow(each)]
        if chosen:
            return chosen
    others = [each for each in ranked if not each.names and each.key not in state.expanded] if max_effects else []
    return [each for each in others if state.is_credible(each) and state.can_grow(each)]


def _expanded(targets: Sequence[Candidate], parts: Sequence[Part], pool: FitPool, state: _State) -> list[Candidate]:
    """Return full fits of the best models with one part more than the targets."""
    asked = state.propose([(each, [part for part in parts if part.name not in each.names]) for each in targets], pool)
    tasks: dict[Key, tuple[Fit, Proposal]] = {}
    for base, proposals in zip(targets, asked, strict=True):
        for proposal in screened(proposals, alone=not base.names):
            tasks.setdefault(proposal.hypothesis.key, (base.fit, proposal))
    new = [task for key, task in tasks.items() if key not in state.fitted]
    return pool.full(_promising(laws_first(from_one_basin(new, pool)), state, _LEAST, _MOST))


def _promising(quick: Sequence[Fit], state: _State, least: int, most: int) -> list[Fit]:
    """Return the quick fits that may become credible, and in any case the first few."""

    def fits(each: Fit) -> float:
        misfits = lasting_squares(each.residuals, state.data.groups)
        return likelihood(misfits, state.data, state.calibration) - state.calibration.cause * len(each.hypothesis.parts)

    ranked = [fits(each) for each in quick]
    limit = max([*ranked, state.least]) - _ROUGH if ranked else 0.0
    return [each for place, (each, value) in enumerate(zip(quick, ranked, strict=True)) if place < least or value > limit][:most]


def _parts_of_best(pool: FitPool, state: _State) -> list[Candidate]:
    """Return full fits of the best model without each of its parts, unless they exist already."""
    best = state.ranked[0]
    if len(best.names) < 2:
        return []
    smaller = [without(best.fit, name) for name in best.names]
    return pool.full([each for each in smaller if each.hypothesis.key not in state.fitted])


def _relatives(state: _State) -> list[Candidate]:
    """Return the most credible models whose laws have not been replaced by their variants and special cases yet."""
    credible = [each for each in state.ranked if each.names and state.is_credible(each)]
    return [each for each in credible[:_BEAM] if each.key not in state.varied]


def _varied(models: Sequence[Candidate], parts: Sequence[Part], pool: FitPool, state: _State) -> list[Candidate]:
    """Return full fits of the models with other variants or special cases in place of each of their laws."""
    asked: list[tuple[Candidate, list[Part]]] = []
    for model in models:
        for part in model.fit.hypothesis.parts:
            base = state.fitted.get(without(model.fit, part.name).hypothesis.key)
            rest = set(model.names) - {part.name}
            relatives = [other for other in parts if other.name not in rest and (other.name == part.name or part.contains(other))]
            if base is not None and relatives:
                asked.append((base, relatives))
    new: list[Fit] = []
    for (base, _), proposals in zip(asked, state.propose(asked, pool), strict=True):
        tasks = [(base.fit, each) for each in proposals if each.hypothesis.key not in state.fitted]
        new += _promising(from_one_basin(tasks, pool), state, 1, _SIBLINGS)
    first = {each.hypothesis.key: each for each in new}
    return pool.full(list(first.values()))
