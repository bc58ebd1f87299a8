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
from hsr_pin.inference.residuals import lasting_square
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
    """Return the noise variance and the number of coordinates of the recordings."""
    seen = sum(int(np.isfinite(run.compared).sum()) for run in problem.runs)
    return Data(float(np.mean(problem.noise**2)), seen)


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
    facts, axes = fit.hypothesis.parameters, fit.residuals[0].shape[-1]
    widths = np.array([fact.prior_width(value) for fact, value in zip(facts, fit.values, strict=True)])
    departures = np.array([fact.departure(value) for fact, value in zip(facts, fit.values, strict=True)])
    eigenvalues = information([slopes for _, slopes in fit.whitened()], widths)
    square = 1 / float(np.mean(1 / problem.floor**2))  # residuals are whitened by it
    at_bound = {name.partition(".")[0] for name in fit.on_bound()}
    causes = tuple(
        Cause(part.name, part.kind, part.flexible or part.name in at_bound, variants.get(part.name, 1))
        for part in fit.hypothesis.parts
    )
    return Model(causes, lasting_square(fit.residuals) / axes, eigenvalues * square, departures)
