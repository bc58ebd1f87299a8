"""Candidate models: a fit with its held-out error and its summary for the evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.heldout import leave_one_out
from hsr_pin.inference.model import Cause, Data, Model, information
from hsr_pin.inference.problem import Problem
from hsr_pin.inference.resampling import squares
from hsr_pin.inference.residuals import lasting_squares
from hsr_pin.trajectory import Array

#: Key that distinguishes a model from other models of the same recordings.
Key = tuple[object, ...]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fitted model and its error on held-out trials.

    Attributes:
        fit: fit of the nominal model with its causes.
        heldout: for each run (T, M, A) predicted minus measured, where the prediction is fitted to the other runs.
        model: summary of the fit for the evidence.
    """

    fit: Fit
    heldout: tuple[Array, ...]
    model: Model

    @property
    def names(self) -> tuple[str, ...]:
        """Sorted names of the causes."""
        return self.model.names

    @property
    def key(self) -> Key:
        """Key that distinguishes the model from other models of the same recordings."""
        key: Key = self.fit.hypothesis.key
        return key

    @property
    def heldout_square(self) -> float:
        """Mean squared distance on held-out trials [m^2]."""
        return squares(self.heldout).mean

    def special_case_of(self, other: Candidate) -> bool:
        """Return whether this model is a special case of another model.

        It is one if it lacks a part of the other model, or has a law that is contained in a law of the other model. With the same
        laws it is one if it has one size for all stiffness levels where the other model has one for each level.
        """
        own, others = ({part.name: part for part in each.fit.hypothesis.parts} for each in (self, other))
        if not own:
            return False
        if own.keys() == others.keys():
            unlike = [(others[name], part) for name, part in own.items() if others[name].variant != part.variant]
            return bool(unlike) and all(general.contains(part) for general, part in unlike)
        if own.keys() < others.keys():
            return True
        general = [part for name, part in others.items() if name not in own]
        return all(name in others or any(each.contains(part) for each in general) for name, part in own.items())


def data_of(problem: Problem) -> Data:
    """Return the variance of noise and of known inaccuracies, and the number of coordinates of the recordings."""
    groups = [list(own) for own in problem.groups]
    seen = [sum(int(np.isfinite(run.compared[:, own]).sum()) for run in problem.runs) for own in groups]
    noise, discrepancy = (np.array([np.mean(each[own]) for own in groups]) for each in (problem.noise**2, problem.discrepancy**2))
    return Data(problem.groups, noise, np.array(seen), discrepancy)


def full_fit(problem: Problem, start: Fit, variants: Mapping[str, int]) -> Candidate:
    """Return the full fit that starts from the result of a quick fit, with its held-out errors.

    Args:
        problem: the recordings and their simulation.
        start: model and initial values.
        variants: number of variants of each law in the catalogue.
    """
    answer = fit(problem, start.hypothesis, start=start.values)
    return candidate(problem, answer, variants)


def candidate(problem: Problem, fit: Fit, variants: Mapping[str, int]) -> Candidate:
    """Return a fit as a candidate with its held-out errors; the arguments are those of :func:`full_fit`."""
    return Candidate(fit, tuple(leave_one_out(problem, fit)), model_of(problem, fit, variants))


def model_of(problem: Problem, fit: Fit, variants: Mapping[str, int]) -> Model:
    """Return the summary of a fit for the evidence, with the parameters of single trials marginalised."""
    facts, errors, slopes_of = fit.hypothesis.parameters, fit.errors, [slopes for _, slopes in fit.whitened()]
    whitened = []
    for k, (run, weights) in enumerate(zip(problem.runs, fit.weights, strict=True)):
        tolerances = (problem.tolerances(run) * weights[..., None])[weights > 0]
        whitened.append(np.hstack([slopes_of[k], fit.eliminated(k)(tolerances)]))
    widths = np.array([fact.prior_width(value) for fact, value in zip(facts, fit.values, strict=True)])
    departures = np.array([fact.departure(value) for fact, value in zip(facts, fit.values, strict=True)])
    channels = [np.nonzero(weights > 0)[1] for weights in fit.weights]
    matrices = []
    for own in map(list, problem.groups):
        slopes = [rows[np.isin(channel, own)] for rows, channel in zip(whitened, channels, strict=True)]
        square = 1 / float(np.mean(1 / problem.floor[own] ** 2))  # residuals are whitened by it
        matrices.append(square * information(slopes, np.append(widths, np.ones(len(errors)))))
    at_bound = {name.partition(".")[0] for name in fit.on_bound()}
    causes = tuple(
        Cause(part.name, part.kind, part.flexible or part.name in at_bound, variants.get(part.name, 1))
        for part in fit.hypothesis.parts
    )
    return Model(causes, lasting_squares(fit.residuals, problem.groups), np.array(matrices), departures, errors)
